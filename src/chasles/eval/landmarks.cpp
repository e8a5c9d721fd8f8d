#include <cmath>

#include <Eigen/Geometry>

#include <chasles/eval/landmarks.hpp>

namespace chasles {
namespace {

double rmse(const std::vector<MatchedPoint>& points, const SE3& truth_T_estimate) {
  double sum = 0;
  for (const MatchedPoint& point : points) {
    sum += (truth_T_estimate * point.p_estimate - point.p_truth).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

SE3 least_squares(const std::vector<MatchedPoint>& points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    from.col(i) = points[static_cast<std::size_t>(i)].p_estimate;
    to.col(i) = points[static_cast<std::size_t>(i)].p_truth;
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, /*with_scaling=*/false);
  return {T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
}

}  // namespace

LandmarkError landmark_error(const std::vector<MatchedPoint>& points, const SE3& truth_T_estimate) {
  LandmarkError result{.count = points.size(), .rmse_first_pose_m = 0, .rmse_aligned_m = {}};
  if (points.empty()) return result;
  result.rmse_first_pose_m = rmse(points, truth_T_estimate);
  if (points.size() >= 3) result.rmse_aligned_m = rmse(points, least_squares(points));
  return result;
}

}  // namespace chasles
