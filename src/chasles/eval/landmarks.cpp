#include <cmath>

#include <chasles/eval/alignment.hpp>
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
  MatchedTrajectories matched;
  for (const MatchedPoint& point : points) {
    matched.estimate.push_back({.pose = {.p = point.p_estimate}});
    matched.truth.push_back({.pose = {.p = point.p_truth}});
  }
  return align(matched, Alignment::kRigid).truth_T_estimate;
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
