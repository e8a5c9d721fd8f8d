#include "thresholds.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "options.hpp"

namespace chasles::app {

std::vector<Threshold> truth_thresholds() {
  return {
      {"--ate-below", "ate_m", "M", "position error, SE(3)-aligned rmse"},
      {"--attitude-below", "attitude_deg", "DEG", "attitude error, SE(3)-aligned rmse"},
      {"--rpe-below", "rpe_100m_percent", "PERCENT", "relative error over 100 m"},
      {"--nees-below", "nees_pose", "X", "mean NEES of the pose (6 is consistent)"},
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
  for (const Threshold& t : thresholds) {
    if (!t.limit) continue;
    const auto figure = figures.find(t.figure);
    const char* side = t.below ? "below" : "above";
    if (figure == figures.end() || !figure->is_number()) {
      sentences.push_back(
          fmt::format("{} has no value here, asked for {} {}", t.figure, side, *t.limit));
      continue;
    }
    const double value = figure->get<double>();
    if (t.below ? value < *t.limit : value > *t.limit) continue;
    sentences.push_back(
        fmt::format("{} is {:.4g}, asked for {} {}", t.figure, value, side, *t.limit));
  }
  return sentences;
}

}  // namespace chasles::app
