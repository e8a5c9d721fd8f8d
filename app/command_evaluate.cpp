#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/data/readers.hpp>
#include <chasles/data/run.hpp>
#include <chasles/data/utf8.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/evaluation.hpp>

#include "run_figures.hpp"
#include "run_input.hpp"
#include "subcommands.hpp"
#include "thresholds.hpp"

namespace chasles::app {
namespace {

struct EvaluateOptions {
  std::filesystem::path estimate, truth;
  bool json = false, markdown = false;
  std::vector<Threshold> thresholds = truth_thresholds();
};

struct EvaluatedEstimate {
  Trajectory trajectory;
  std::vector<Matrix6d> covariances;  ///< empty: unknown
  Trajectory truth;                   ///< of the run folder
  std::string chart = "standard";
  bool level = false;  ///< its world's z axis is vertical
};

EvaluatedEstimate read_estimate(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) {
    return {.trajectory = read_tum(path), .covariances = {}, .truth = {}};
  }
  const Run run = read_run(path);
  EvaluatedEstimate estimate{.trajectory = {}, .covariances = {}, .truth = run.truth};
  estimate.level = is_level(run);
  for (const RunState& s : run.states) {
    estimate.trajectory.push_back({.time = s.time, .pose = s.world_T_imu});
    estimate.covariances.push_back(s.pose_covariance);
  }
  const auto summary = read_summary(path);
  if (summary.contains("chart")) estimate.chart = summary["chart"].get<std::string>();
  return estimate;
}

std::string markdown(const Evaluation& evaluation) {
  std::string text;
  for (const Table& table : {absolute_table(evaluation), distance_table(evaluation),
                             time_table(evaluation), nees_table(evaluation)}) {
    if (!table.rows.empty()) text += (text.empty() ? "" : "\n") + to_markdown(table);
  }
  return text;
}

int run(const EvaluateOptions& o) {
  EvaluatedEstimate estimate = read_estimate(o.estimate);
  if (!o.truth.empty()) estimate.truth = read_truth(o.truth);
  if (estimate.truth.empty()) {
    throw UsageError(fmt::format("{} has no truth: expected a TRUTH", o.estimate.string()));
  }
  EvaluationOptions options;
  options.pose_error = pose_error_of(estimate.chart);
  options.level = estimate.level;
  const Evaluation evaluation =
      evaluate(estimate.trajectory, estimate.truth, estimate.covariances, options);
  const nlohmann::ordered_json json = figures_json(evaluation);
  fmt::print("{}", o.json       ? json_text(json, 2) + "\n"
                   : o.markdown ? markdown(evaluation)
                                : to_text(evaluation));
  const std::vector<std::string> sentences = missed(o.thresholds, json);
  for (const std::string& sentence : sentences) spdlog::error("missed: {}", sentence);
  return static_cast<int>(sentences.empty() ? ExitCode::kOk : ExitCode::kThresholdMissed);
}

}  // namespace

Action declare_evaluate(CLI::App& parser) {
  const auto o = std::make_shared<EvaluateOptions>();
  parser
      .add_option("ESTIMATE", o->estimate, "Run folder (with NEES), or TUM trajectory of the IMU")
      ->required()
      ->type_name("");
  parser
      .add_option("TRUTH", o->truth,
                  "TUM trajectory of the IMU, or a recording that has the truth (default: that of "
                  "the run folder)")
      ->type_name("");
  CLI::Option* json = parser.add_flag("--json", o->json, "Print the figures as JSON");
  parser.add_flag("--markdown", o->markdown, "Print the tables as Markdown")->excludes(json);
  add_options(parser, o->thresholds);
  return [o] { return run(*o); };
}

}  // namespace chasles::app
