
#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/report/against_truth.hpp>

namespace chasles {
namespace {

void compare(AgainstTruth& out, const std::vector<Matrix6d>& covariances,
             PoseError nees_coordinates, bool level, bool stated_attitudes) {
  const MatchedTrajectories& matched = out.matched;
  const bool attitudes = stated_attitudes && !is_without_attitudes(matched.estimate, matched.truth);
  const Alignment first = level ? Alignment::kFirstLevel : Alignment::kFirstPose;
  out.world_T_truth_first = (attitudes ? align(matched, first).truth_T_estimate
                                       : first_position_alignment(matched, level))
                                .inverse();
  out.world_T_truth_fit = align(matched, Alignment::kRigid).truth_T_estimate.inverse();
  out.nees = attitudes ? nees(matched, covariances, nees_coordinates, level)
                       : position_nees(matched, covariances, level);
  for (std::size_t row = 0; row < matched.estimate.size(); ++row) {
    const std::size_t state = matched.estimate_index[row];
    const SE3 truth = out.world_T_truth_first * matched.truth[row].pose;
    out.error[state] = pose_error(PoseError::kStandard, truth, matched.estimate[row].pose);
    if (!attitudes) out.error[state].head<3>().setConstant(kNaN);
    out.nees_pose[state] = out.nees.pose[row];
    out.nees_attitude[state] = out.nees.attitude[row];
    out.nees_position[state] = out.nees.position[row];
  }
}

}  // namespace

AgainstTruth against_truth(const Run& run, PoseError nees_coordinates, bool attitudes) {
  const std::vector<RunState>& states = run.states;
  const std::vector<double> unknown(states.size(), kNaN);
  AgainstTruth out;
  out.nees.definition = nees_coordinates;
  out.error.assign(states.size(), Vector6d::Constant(kNaN));
  out.nees_pose = out.nees_attitude = out.nees_position = unknown;
  Trajectory estimate;
  std::vector<std::size_t> finite;  // a pose that is not finite would invalidate the alignments
  std::vector<Matrix6d> covariances;
  for (std::size_t i = 0; i < states.size(); ++i) {
    covariances.push_back(states[i].pose_covariance);
    const SE3& pose = states[i].world_T_imu;
    if (!pose.R.allFinite() || !pose.p.allFinite()) continue;
    estimate.push_back({states[i].time, pose});
    finite.push_back(i);
  }
  try {
    out.matched = associate(estimate, run.truth, run.pairing);
    for (std::size_t& row : out.matched.estimate_index) row = finite[row];
    compare(out, covariances, nees_coordinates, is_level(run), attitudes);
  } catch (const InputError& error) {
    // The page is still useful without the comparison; it states the reason.
    out.problem = error.what();
  }
  return out;
}

}  // namespace chasles
