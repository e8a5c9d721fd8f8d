#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/session/truth_errors_json.hpp>
#include <chasles/session/truth_mending.hpp>
#include <chasles/session/truth_of_run.hpp>
#include <chasles/session/truth_preparation.hpp>

namespace chasles {

void prepare_truth_of_run(const TruthOptions& options, Recording& recording, RecordedRun& result) {
  Run& run = result.run;
  if (run.truth.empty() || run.states.empty()) return;
  TruthReference reference{.name = "the estimate",
                           .poses = {},
                           .level = is_level(run),
                           .frames = known_frames(recording)};
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.R.allFinite() || !s.world_T_imu.p.allFinite()) continue;
    reference.poses.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  const TruthToPrepare how{.attitudes = recording.truth_attitudes,
                           .point_imu = recording.truth_point_imu,
                           .estimate_offset = is_offset_auto(options),
                           .turn_to_level = is_level(run) && !recording.truth_level.value_or(true),
                           .pairing = run.pairing};
  const auto keep_remarks = [&](const PreparedTruth& prepared_truth) {
    for (const std::string& remark : prepared_truth.remarks) recording.remarks.push_back(remark);
    for (const TruthFinding& f : prepared_truth.findings) recording.remarks.push_back(sentence(f));
  };
  try {
    const PreparedTruth prepared_truth = prepare_truth(reference, how, run.truth);
    keep_remarks(prepared_truth);
    result.truth_attitudes = prepared_truth.attitudes;
    result.truth_findings = prepared_truth.findings;
    if (!prepared_truth.tilt) return;
    for (TrueLandmark& landmark : recording.true_landmarks) {
      landmark.p_world = prepared_truth.tilt->level_R_truth * landmark.p_world;
    }
    result.truth_tilt_deg = prepared_truth.tilt->degrees;
  } catch (const InputError& error) {
    if (how.estimate_offset) {
      recording.remarks.push_back(fmt::format("not evaluated: {}", error.what()));
      run.truth.clear();
      return;
    }
    // The evaluation reports why the truth cannot be compared; the findings may say more.
    keep_remarks({.findings = examine_truth(reference, run.truth,
                                            {.gap = run.pairing.longest_gap,
                                             .positions_only = !how.attitudes})
                                  .findings,
                  .tilt = {},
                  .remarks = {}});
  }
}

void add_truth_errors(const TruthOptions& options, const RecordedRun& result,
                      nlohmann::ordered_json& summary) {
  const Run& run = result.run;
  if (!are_errors_auto(options) || run.truth.empty() || run.states.empty()) return;
  if (!result.truth_attitudes) {
    summary["remarks"].push_back("--truth-errors auto: the truth has positions alone");
    return;
  }
  if (!result.truth_findings.empty()) summary["remarks"].push_back(std::string(kMendTruthFirst));
  Trajectory estimate;
  std::vector<Matrix6d> covariances;
  for (const RunState& s : run.states) {
    estimate.push_back({.time = s.time, .pose = s.world_T_imu});
    covariances.push_back(s.pose_covariance);
  }
  try {
    summary["truth_errors"] = truth_errors_json(
        estimate_truth_errors(estimate, run.truth, covariances,
                              {.pairing = run.pairing,
                               .pose_error = pose_error_of(summary.at("chart").get<std::string>()),
                               .level = is_level(run),
                               .priors = {}}));
  } catch (const InputError& error) {
    summary["remarks"].push_back(fmt::format("--truth-errors auto: {}", error.what()));
  }
}

}  // namespace chasles
