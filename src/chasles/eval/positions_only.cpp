#include <algorithm>
#include <vector>

#include <chasles/base/constants.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

bool is_without_attitudes(const Trajectory& estimate, const Trajectory& truth) {
  constexpr double kSameRotation = 1e-6, kTurns = 5 * kRadians;
  if (truth.empty() || estimate.empty()) return false;
  const auto apart = [](const Trajectory& poses, double angle) {
    return std::ranges::any_of(poses, [&](const StampedPose& row) {
      return so3::log(poses.front().pose.R.transpose() * row.pose.R).norm() > angle;
    });
  };
  return !apart(truth, kSameRotation) && apart(estimate, kTurns);
}

SE3 first_position_alignment(const MatchedTrajectories& matched, bool level) {
  SE3 fit = align(matched, level ? Alignment::kPositionYaw : Alignment::kRigid).truth_T_estimate;
  fit.p = matched.truth.front().pose.p - fit.R * matched.estimate.front().pose.p;
  return fit;
}

Nees position_nees(const MatchedTrajectories& matched, std::span<const Matrix6d> covariances,
                   bool level) {
  if (matched.truth.empty()) return {};
  const SE3 estimate_T_truth = first_position_alignment(matched, level).inverse();
  std::vector<SE3> truths;  // with the attitudes of the estimate
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    truths.push_back({matched.estimate[i].pose.R, estimate_T_truth * matched.truth[i].pose.p});
  }
  Nees result = nees_of_truths(matched, truths, covariances, PoseError::kStandard);
  result.attitude.assign(truths.size(), kNaN);
  result.pose.assign(truths.size(), kNaN);
  result.attitude_summary = summarize_nees({}, 3);
  result.pose_summary = summarize_nees({}, 6);
  std::fill_n(result.within_3_sigma.count.begin(), 3, 0);
  std::fill_n(result.within_3_sigma.share.begin(), 3, kNaN);
  return result;
}

}  // namespace chasles
