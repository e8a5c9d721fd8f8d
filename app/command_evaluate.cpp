#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/eval/truth_errors_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/growing_run.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/run_figures.hpp>
#include <chasles/session/truth_errors_json.hpp>
#include <chasles/session/truth_mending.hpp>
#include <chasles/session/truth_options.hpp>
#include <chasles/session/truth_preparation.hpp>

#include "declare_truth.hpp"
#include "evaluate_pair.hpp"
#include "print.hpp"
#include "subcommands.hpp"
#include "thresholds.hpp"

namespace chasles::app {
namespace {

struct EvaluateOptions {
  std::filesystem::path estimate, truth;
  TruthOptions truth_options;
  bool json = false, markdown = false, pair = false, smoothed = false;
  std::vector<Threshold> thresholds = truth_thresholds();
};

struct EvaluatedEstimate {
  Trajectory trajectory;
  std::vector<Matrix6d> covariances;  ///< empty: unknown
  Trajectory truth;                   ///< of the run folder
  TruthPairing pairing = {};
  std::optional<double> coverage = {}, truth_tilt_deg = {};  ///< of the run
  std::string chart = "standard";
  bool level = false;                   ///< its world's z axis is vertical
  std::vector<KnownFrame> frames = {};  ///< of the run
  bool attitudes = true;                ///< the truth has them
  std::vector<TruthFinding> findings = {};
};

bool is_run_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path / "states.csv", ignored) ||
         std::filesystem::exists(growing_folder(path) / "states.csv", ignored);
}

// In evo's order of arguments a run would be compared with itself: its truth with the truth that it
// was given.
void check_order(const EvaluateOptions& o) {
  if (o.truth.empty() || !is_run_folder(o.truth)) return;
  const std::string run = o.truth.string();
  throw UsageError(fmt::format(
      "{} is a run folder, which holds an estimate; expected the truth second: {}", run,
      is_run_folder(o.estimate)
          ? fmt::format("{0}/truth.tum, or {0}/trajectory.tum to compare two estimates", run)
          : fmt::format("`chasles evaluate {} {}`, or {}/truth.tum to compare {} with it", run,
                        o.estimate.string(), run, o.estimate.string())));
}

// The poses of states.csv or smoothed.csv with their covariances.
void take_poses(const auto& poses, EvaluatedEstimate& estimate) {
  for (const auto& s : poses) {
    estimate.trajectory.push_back({.time = s.time, .pose = s.world_T_imu});
    estimate.covariances.push_back(s.pose_covariance);
  }
}

EvaluatedEstimate read_estimate(const EvaluateOptions& o, std::vector<std::string>& remarks) {
  const std::filesystem::path& path = o.estimate;
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) {
    if (o.smoothed) {
      throw UsageError(
          fmt::format("--smoothed: {} is a file, expected a run folder", path.string()));
    }
    return {.trajectory = read_tum(path, remarks), .covariances = {}, .truth = {}};
  }
  const Run run = read_run(path);
  EvaluatedEstimate estimate{.trajectory = {}, .covariances = {}, .truth = run.truth};
  estimate.level = is_level(run);
  if (o.smoothed) {
    take_poses(run.smoothed, estimate);
  } else {
    take_poses(run.states, estimate);
  }
  if (o.smoothed && run.smoothed.empty()) {
    throw UsageError(
        fmt::format("--smoothed: {} has no smoothed.csv, expected the run of a filter with "
                    "exact_map (docs/map.md)",
                    path.string()));
  }
  estimate.pairing = run.pairing;
  const auto summary = read_summary(path);
  estimate.frames = known_frames(summary);
  estimate.attitudes = summary.value("truth_attitudes", true);
  const auto chart = summary.find("chart"), coverage = summary.find("coverage"),
             tilt = summary.find("truth_tilt_deg");
  if (chart != summary.end() && chart->is_string()) estimate.chart = chart->get<std::string>();
  if (coverage != summary.end() && coverage->is_number()) estimate.coverage = *coverage;
  if (tilt != summary.end() && tilt->is_number()) estimate.truth_tilt_deg = *tilt;
  return estimate;
}

TruthReference reference_of(const EvaluatedEstimate& estimate) {
  TruthReference reference{
      .name = "the estimate", .poses = {}, .level = {}, .frames = estimate.frames};
  if (!estimate.covariances.empty()) reference.level = estimate.level;
  for (const StampedPose& row : estimate.trajectory) {
    if (row.pose.R.allFinite() && row.pose.p.allFinite()) reference.poses.push_back(row);
  }
  return reference;
}

// The truth to compare with: the given one or the run's, in the form that the options state. Of one
// whose times have nothing in common with the estimate's the offset is added to the error.
void take_truth(const EvaluateOptions& o, EvaluatedEstimate& estimate,
                std::vector<std::string>& remarks) {
  StatedTruth truth{.poses = std::move(estimate.truth),
                    .level = true,  // the run has turned its truth if it was not
                    .attitudes = estimate.attitudes};
  if (!o.truth.empty()) {
    truth = read_truth(o.truth, remarks);
    estimate.truth_tilt_deg.reset();
  }
  if (truth.poses.empty()) {
    throw UsageError(fmt::format("{} has no truth: expected a TRUTH", o.estimate.string()));
  }
  // Before it is mended: what begins at the identity then begins elsewhere.
  const bool level = is_truth_level(o.truth_options, stated_level(truth), truth.poses);
  mend_truth(o.truth_options, estimate.frames, truth);
  const bool run = !estimate.covariances.empty();
  if (run && !estimate.level) check_level_is_auto(o.truth_options);
  // Of a trajectory alone it is not known whether its z axis is vertical.
  const bool vertical = run ? estimate.level : o.truth_options.level == "no";
  const PreparedTruth prepared_truth =
      prepare_truth(reference_of(estimate),
                    {.attitudes = truth.attitudes,
                     .point_imu = truth.point_imu,
                     .estimate_offset = is_offset_auto(o.truth_options),
                     .turn_to_level = !level && vertical,
                     .pairing = pairing_from(o.truth_options, estimate.pairing)},
                    truth.poses);
  estimate.truth = std::move(truth.poses);
  estimate.attitudes = prepared_truth.attitudes;
  estimate.findings = prepared_truth.findings;
  if (prepared_truth.tilt) estimate.truth_tilt_deg = prepared_truth.tilt->degrees;
  remarks.insert(remarks.end(), prepared_truth.remarks.begin(), prepared_truth.remarks.end());
  for (const TruthFinding& finding : prepared_truth.findings) remarks.push_back(sentence(finding));
}

void warn_of_misreading(const EvaluatedEstimate& estimate, const TruthPairing& pairing) {
  constexpr double kRounding = 1e-9;  // [m]
  const MatchedTrajectories matched = associate(estimate.trajectory, estimate.truth, pairing);
  if (absolute_error(matched, Alignment::kNone).position_m.max > kRounding) return;
  spdlog::warn("the estimate equals the truth at all {} stamps: is it the same trajectory twice?",
               matched.truth.size());
}

std::vector<Table> tables_of(const Evaluation& evaluation,
                             const std::optional<TruthErrors>& truth_errors) {
  std::vector<Table> tables = {absolute_table(evaluation), distance_table(evaluation),
                               time_table(evaluation), nees_table(evaluation),
                               within_3_sigma_table(evaluation)};
  if (truth_errors) {
    tables.push_back(truth_errors_table(*truth_errors));
    tables.push_back(without_truth_errors_table(evaluation, *truth_errors));
  }
  return tables;
}

std::string markdown(const Evaluation& evaluation, const std::optional<TruthErrors>& truth_errors) {
  std::string text;
  for (const Table& table : tables_of(evaluation, truth_errors)) {
    if (!table.rows.empty()) text += (text.empty() ? "" : "\n") + to_markdown(table);
  }
  return text;
}

std::string plain_text(const Evaluation& evaluation,
                       const std::optional<TruthErrors>& truth_errors) {
  if (!truth_errors) return to_text(evaluation);
  return fmt::format("{}\n{}\n{}", to_text(evaluation), to_text(truth_errors_table(*truth_errors)),
                     to_text(without_truth_errors_table(evaluation, *truth_errors)));
}

// With --truth-errors auto.
std::optional<TruthErrors> truth_errors_of(const EvaluateOptions& o,
                                           const EvaluatedEstimate& estimate,
                                           const EvaluationOptions& options) {
  if (!are_errors_auto(o.truth_options)) return std::nullopt;
  if (estimate.covariances.empty()) {
    throw UsageError(fmt::format(
        "--truth-errors auto: {} is a trajectory without covariances, expected a run folder",
        o.estimate.string()));
  }
  if (!estimate.attitudes) {
    throw UsageError(
        "--truth-errors auto: the truth has positions alone, expected poses with attitudes");
  }
  if (!estimate.findings.empty()) spdlog::warn("{}", kMendTruthFirst);
  return estimate_truth_errors(estimate.trajectory, estimate.truth, estimate.covariances,
                               {.pairing = options.pairing,
                                .pose_error = options.pose_error,
                                .level = options.level,
                                .priors = {}});
}

int run(const EvaluateOptions& o) {
  if (o.pair) {
    const Form form = o.json ? Form::kJson : o.markdown ? Form::kMarkdown : Form::kText;
    app::print("{}", evaluated_pair(o.estimate, o.truth, form));
    return static_cast<int>(ExitCode::kOk);
  }
  check_order(o);
  std::vector<std::string> remarks;
  EvaluatedEstimate estimate = read_estimate(o, remarks);
  take_truth(o, estimate, remarks);
  for (const std::string& remark : remarks) spdlog::warn("{}", remark);
  EvaluationOptions options;
  options.pose_error = pose_error_of(estimate.chart);
  options.level = estimate.level;
  options.attitudes = estimate.attitudes;
  options.pairing = pairing_from(o.truth_options, estimate.pairing);
  const Evaluation evaluation =
      evaluate(estimate.trajectory, estimate.truth, estimate.covariances, options);
  warn_of_misreading(estimate, options.pairing);
  const auto truth_errors = truth_errors_of(o, estimate, options);
  nlohmann::ordered_json json = figures_json(evaluation);
  if (estimate.coverage) json["coverage"] = *estimate.coverage;
  if (estimate.truth_tilt_deg) json["truth_tilt_deg"] = *estimate.truth_tilt_deg;
  if (!estimate.attitudes) json["truth_attitudes"] = false;
  if (!estimate.findings.empty()) json["truth_findings"] = truth_findings_json(estimate.findings);
  if (truth_errors) json["truth_errors"] = truth_errors_json(*truth_errors);
  app::print("{}", o.json       ? json_text(json, 2) + "\n"
                   : o.markdown ? markdown(evaluation, truth_errors)
                                : plain_text(evaluation, truth_errors));
  const std::vector<std::string> sentences = missed(o.thresholds, json);
  for (const std::string& sentence : sentences) spdlog::error("missed: {}", sentence);
  return static_cast<int>(sentences.empty() ? ExitCode::kOk : ExitCode::kThresholdMissed);
}

}  // namespace

Action declare_evaluate(CLI::App& parser) {
  const auto o = std::make_shared<EvaluateOptions>();
  parser
      .add_option("ESTIMATE", o->estimate,
                  "Run folder (with NEES), or trajectory of the IMU: TUM, or a table of EuRoC")
      ->required()
      ->type_name("");
  parser
      .add_option(
          "TRUTH", o->truth,
          "Trajectory of the IMU, a bag with its poses (FILE or FILE:TOPIC), or a recording "
          "that has the truth (default: that of the run folder)")
      ->type_name("");
  CLI::Option* json = parser.add_flag("--json", o->json, "Print the figures as JSON");
  parser.add_flag("--markdown", o->markdown, "Print the tables as Markdown")->excludes(json);
  const std::size_t of_both = parser.get_options().size();
  parser.add_flag("--smoothed", o->smoothed, "The smoothed path of the run folder");
  declare_truth(parser, o->truth_options, "Options");
  declare_truth_errors(parser, o->truth_options, "Options");
  add_options(parser, o->thresholds);
  std::vector<CLI::Option*> of_a_truth = parser.get_options();
  of_a_truth.erase(of_a_truth.begin(), of_a_truth.begin() + static_cast<std::ptrdiff_t>(of_both));
  CLI::Option* pair = parser.add_flag(
      "--pair", o->pair,
      "ESTIMATE and TRUTH are two run folders of one recording with other tracks "
      "(run --tracks 0.5, and with --tracks-rest): whether their covariances explain "
      "how they differ. Needs no truth");
  for (CLI::Option* option : of_a_truth) pair->excludes(option);
  return [o] { return run(*o); };
}

}  // namespace chasles::app
