#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/pair_difference.hpp>

namespace chasles {
namespace {

constexpr double kRounding = 1e-9;  // of equal estimates [m, rad]

void check_covariances(const EstimatedPath& path, const char* which) {
  if (path.covariances.size() == path.poses.size()) return;
  throw InputError(fmt::format("the {} estimate: {} covariances for {} poses, expected one a pose",
                               which, path.covariances.size(), path.poses.size()));
}

// The row whose time is nearest.
std::size_t nearest_row(const Trajectory& poses, Time time) {
  const auto after = std::ranges::lower_bound(poses, time, {}, &StampedPose::time);
  if (after == poses.begin()) return 0;
  const auto i = static_cast<std::size_t>(after - poses.begin());
  const bool before = after == poses.end() || time - poses[i - 1].time < after->time - time;
  return before ? i - 1 : i;
}

// Of standard errors, in the axes of another world.
Matrix6d turned(const Eigen::Matrix3d& R, const Matrix6d& covariance) {
  Matrix6d M = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = M.bottomRightCorner<3, 3>() = R;
  return M * covariance * M.transpose();
}

double rms(double sum, std::size_t count) { return std::sqrt(sum / static_cast<double>(count)); }

}  // namespace

double PairDifference::factor() const { return std::sqrt(pose.mean / pose.dof); }

PairDifference pair_difference(const EstimatedPath& a, const EstimatedPath& b, bool level) {
  check_covariances(a, "first");
  check_covariances(b, "second");
  const MatchedTrajectories matched = associate(a.poses, b.poses);
  const SE3 a_T_b = align(matched, level ? Alignment::kFirstLevel : Alignment::kFirstPose)
                        .truth_T_estimate.inverse();
  std::vector<SE3> others;
  std::vector<Matrix6d> sums(a.poses.size(), Matrix6d::Zero());
  double positions = 0, attitudes = 0;
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    others.push_back(a_T_b * matched.truth[i].pose);
    const std::size_t row = matched.estimate_index[i];
    const std::size_t of_b = nearest_row(b.poses, matched.estimate[i].time);
    sums[row] = a.covariances[row] + turned(a_T_b.R, b.covariances[of_b]);
    const Vector6d d = pose_error(PoseError::kStandard, others.back(), matched.estimate[i].pose);
    attitudes += d.head<3>().squaredNorm();
    positions += d.tail<3>().squaredNorm();
  }
  const std::size_t n = matched.truth.size();
  if (rms(positions, n) < kRounding && rms(attitudes, n) < kRounding) {
    throw InputError(
        "the two estimates are equal at all times: expected runs on different tracks (`chasles run "
        "--tracks 0.5`, and the same with --tracks-rest)");
  }
  const Nees nees = nees_of_truths(matched, others, sums, PoseError::kStandard);
  if (2 * nees.pose_summary.count < n) {
    throw InputError(
        fmt::format("the covariances of both are singular or not finite at {} of {} times, "
                    "expected covariances",
                    nees.pose_summary.skipped, n));
  }
  return {.compared = n,
          .duration_s = to_seconds(matched.estimate.back().time - matched.estimate.front().time),
          .position_rms_m = rms(positions, n),
          .attitude_rms_deg = rms(attitudes, n) * 180 / std::numbers::pi,
          .position = nees.position_summary,
          .attitude = nees.attitude_summary,
          .pose = nees.pose_summary,
          .within_3_sigma = nees.within_3_sigma};
}

}  // namespace chasles
