#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>

#include <chasles/many/batch_difference.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFigures[] = {"worst_sigma_m", "drift_m_per_100m", "ate_posyaw_m"};

int rank_of(const Json& record) {
  const std::string verdict = record.at("verdict");
  return verdict == "use" ? 0 : verdict == "check" ? 1 : 2;
}

std::optional<double> positive(const Json& record, const char* figure) {
  const auto found = record.find(figure);
  if (found == record.end() || !found->is_number() || found->get<double>() <= 0) {
    return std::nullopt;
  }
  return found->get<double>();
}

// Of the ratios of pairs, by their logarithms.
Json ratio_json(const std::vector<double>& logarithms) {
  const double n = static_cast<double>(logarithms.size());
  double sum = 0, squares = 0;
  for (const double x : logarithms) sum += x;
  const double mean = sum / n;
  for (const double x : logarithms) squares += (x - mean) * (x - mean);
  Json json{
      {"pairs", logarithms.size()}, {"ratio", std::exp(mean)}, {"low", nullptr}, {"high", nullptr}};
  if (logarithms.size() >= 2) {
    const double t = boost::math::quantile(boost::math::students_t(n - 1), 0.975);
    const double error = t * std::sqrt(squares / (n - 1) / n);
    json["low"] = std::exp(mean - error);
    json["high"] = std::exp(mean + error);
  }
  return json;
}

std::string names_text(const char* what, const Json& list) {
  std::string text;
  for (const Json& one : list) {
    text += fmt::format("{}: {} (was {}, is {})\n", what, one.at("name").get<std::string>(),
                        one.at("before").get<std::string>(), one.at("now").get<std::string>());
  }
  return text;
}

}  // namespace

Json batch_difference(std::span<const Json> before, std::span<const Json> now) {
  std::map<std::string, const Json*> old, used;
  for (const Json& record : before) old[record.at("name")] = &record;
  Json better = Json::array(), worse = Json::array(), only_now = Json::array();
  std::map<std::string, std::vector<double>> logarithms;
  for (const Json& record : now) {
    const std::string name = record.at("name");
    const auto found = old.find(name);
    if (found == old.end()) {
      only_now.push_back(name);
      continue;
    }
    const Json& earlier = *found->second;
    if (const int change = rank_of(record) - rank_of(earlier); change != 0) {
      (change < 0 ? better : worse)
          .push_back(
              {{"name", name}, {"before", earlier.at("verdict")}, {"now", record.at("verdict")}});
    }
    for (const char* figure : kFigures) {
      const auto a = positive(earlier, figure), b = positive(record, figure);
      if (a && b) logarithms[figure].push_back(std::log(*b / *a));
    }
    old.erase(found);
  }
  Json only_before = Json::array(), figures = Json::object();
  for (const auto& [name, record] : old) only_before.push_back(name);
  for (const char* figure : kFigures) {
    if (logarithms.contains(figure)) figures[figure] = ratio_json(logarithms.at(figure));
  }
  return {{"better", std::move(better)},
          {"worse", std::move(worse)},
          {"only_before", std::move(only_before)},
          {"only_now", std::move(only_now)},
          {"figures", std::move(figures)}};
}

std::string difference_text(const Json& difference) {
  std::string text =
      names_text("worse", difference.at("worse")) + names_text("better", difference.at("better"));
  for (const auto& [figure, ratio] : difference.at("figures").items()) {
    text += fmt::format("{}: {:.3f} times that of the earlier batch", figure,
                        ratio.at("ratio").get<double>());
    if (!ratio.at("low").is_null()) {
      text += fmt::format(" (95 %: {:.3f} to {:.3f})", ratio.at("low").get<double>(),
                          ratio.at("high").get<double>());
    }
    text += fmt::format(", {} recordings\n", ratio.at("pairs").get<std::size_t>());
  }
  return text;
}

}  // namespace chasles
