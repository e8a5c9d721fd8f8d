#include "thresholds.hpp"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/session/coverage.hpp>

#include "options.hpp"

namespace chasles::app {

namespace {

// The limit that applies; a figure of a small part of the recording says little about the rest.
std::optional<double> limit_of(const Threshold& threshold, bool any_given, bool has_value) {
  return threshold.limit || !any_given || !has_value ? threshold.limit : threshold.beside;
}

}  // namespace

std::vector<Threshold> truth_thresholds() {
  return {
      {"--ate-below", "ate_m", "M", "position error, SE(3)-aligned rmse"},
      {"--attitude-below", "attitude_deg", "DEG", "attitude error, SE(3)-aligned rmse"},
      {"--rpe-below", "rpe_100m_percent", "PERCENT", "relative error over 100 m"},
      {"--nees-below", "nees_pose", "X", "mean NEES of the pose (6 is consistent)"},
      {.option = "--coverage-above",
       .figure = "coverage",
       .unit = "SHARE",
       .meaning = fmt::format("estimated share of the frames, 0 to 1 (default with another "
                              "threshold: {:g})",
                              kLeastCoverage),
       .below = false,
       .needs_truth = false,
       .beside = kLeastCoverage},
  };
}

std::vector<Threshold> run_thresholds() {
  std::vector<Threshold> list = truth_thresholds();
  list.push_back({.option = "--nis-below",
                  .figure = "nis_per_dof",
                  .unit = "X",
                  .meaning = "mean NIS per degree of freedom (1 is consistent)",
                  .needs_truth = false});
  list.push_back({.option = "--realtime-above",
                  .figure = "realtime_factor",
                  .unit = "X",
                  .meaning = "speed of the whole run, reading included",
                  .below = false,
                  .needs_truth = false});
  return list;
}

void add_options(CLI::App& parser, std::vector<Threshold>& thresholds) {
  for (Threshold& t : thresholds) {
    add_number(parser, t.option, t.limit, t.unit, t.meaning, 0)->group("Thresholds (exit code 5)");
  }
}

const Threshold* needs_truth(const std::vector<Threshold>& thresholds) {
  for (const Threshold& t : thresholds) {
    if (t.limit && t.needs_truth) return &t;
  }
  return nullptr;
}

std::vector<std::string> missed(const std::vector<Threshold>& thresholds,
                                const nlohmann::ordered_json& figures) {
  std::vector<std::string> sentences;
  const bool any_given =
      std::ranges::any_of(thresholds, [](const Threshold& t) { return t.limit.has_value(); });
  for (const Threshold& t : thresholds) {
    const auto figure = figures.find(t.figure);
    const bool has_value = figure != figures.end() && figure->is_number();
    const std::optional<double> limit = limit_of(t, any_given, has_value);
    if (!limit) continue;
    const char* side = t.below ? "below" : "at least";
    if (!has_value) {
      sentences.push_back(
          fmt::format("{} has no value here, asked for {} {}", t.figure, side, *limit));
      continue;
    }
    const double value = figure->get<double>();
    if (t.below ? value < *limit : value >= *limit) continue;
    sentences.push_back(fmt::format("{} is {:.4g}, asked for {} {}{}", t.figure, value, side,
                                    *limit, t.limit ? "" : fmt::format(" ({})", t.option)));
  }
  return sentences;
}

}  // namespace chasles::app
