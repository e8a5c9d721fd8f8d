#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/session/realtime.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json milliseconds(double seconds) { return std::isfinite(seconds) ? Json(1e3 * seconds) : Json(); }

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(values.size());
  const auto rank = static_cast<std::ptrdiff_t>(std::clamp(std::ceil(p * count), 1.0, count));
  const auto place = values.begin() + (rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

Json realtime_json(const RealtimeFigures& figures) {
  return {{"speed", figures.speed},
          {"frames_came", figures.frames.came},
          {"frames_dropped", figures.frames.dropped},
          {"latency_ms",
           {{"mean", milliseconds(mean(figures.latency))},
            {"p50", milliseconds(quantile(figures.latency, 0.5))},
            {"p99", milliseconds(quantile(figures.latency, 0.99))},
            {"max", milliseconds(quantile(figures.latency, 1))}}}};
}

std::string realtime_text(const Json& realtime) {
  std::string text = fmt::format(
      "\nreal time x {}: {} frames came, {} dropped\n", realtime.at("speed").get<double>(),
      realtime.at("frames_came").get<long>(), realtime.at("frames_dropped").get<long>());
  const Json& ms = realtime.at("latency_ms");
  if (ms.at("mean").is_null()) return text;
  return text + fmt::format(
                    "latency from a frame to its estimate: mean {:.1f}, median {:.1f}, "
                    "p99 {:.1f}, at most {:.1f} ms\n",
                    ms.at("mean").get<double>(), ms.at("p50").get<double>(),
                    ms.at("p99").get<double>(), ms.at("max").get<double>());
}

}  // namespace chasles
