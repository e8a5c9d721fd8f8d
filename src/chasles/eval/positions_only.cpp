#include <algorithm>

#include <fmt/format.h>

#include <chasles/constants.hpp>
#include <chasles/error.hpp>
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
  Nees result;
  if (matched.truth.empty()) return result;
  const SE3 estimate_T_truth = first_position_alignment(matched, level).inverse();
  std::vector<Vector6d> errors;
  std::vector<Matrix6d> matched_covariances;
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    const std::size_t row = matched.estimate_index[i];
    if (row >= covariances.size()) {
      throw InputError(fmt::format(
          "NEES: {} covariances, but pose {} of the estimate needs one; expected one a pose",
          covariances.size(), row));
    }
    const SE3& estimate = matched.estimate[i].pose;
    const SE3 truth{estimate.R, estimate_T_truth * matched.truth[i].pose.p};
    errors.push_back(pose_error(PoseError::kStandard, truth, estimate));
    matched_covariances.push_back(covariances[row]);
    matched_covariances.back().topLeftCorner<3, 3>().setZero();  // counts as not known
    result.times.push_back(matched.estimate[i].time);
    result.position.push_back(
        normalised_square(errors.back().tail<3>(), covariances[row].bottomRightCorner<3, 3>()));
    result.attitude.push_back(kNaN);
    result.pose.push_back(kNaN);
  }
  result.position_summary = summarize_nees(result.position, 3);
  result.attitude_summary = summarize_nees({}, 3);
  result.pose_summary = summarize_nees({}, 6);
  result.within_3_sigma = sigma_shares(errors, matched_covariances);
  return result;
}

}  // namespace chasles
