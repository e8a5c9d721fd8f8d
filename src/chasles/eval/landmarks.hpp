#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <chasles/lie/se3.hpp>

namespace chasles {

/// The estimated and the true position of a landmark.
struct MatchedPoint {
  Eigen::Vector3d p_estimate = Eigen::Vector3d::Zero();  ///< in the estimate's world [m]
  Eigen::Vector3d p_truth = Eigen::Vector3d::Zero();     ///< in the truth's world [m]
};

/// The position error of the landmarks.
struct LandmarkError {
  std::size_t count = 0;
  double rmse_first_pose_m = 0;  ///< with the worlds aligned by the first poses
  std::optional<double>
      rmse_aligned_m;  ///< with alignment by least squares over the landmarks; from 3 landmarks on
};

/// `truth_T_estimate` relates the worlds by the first poses; without points all is zero.
LandmarkError landmark_error(const std::vector<MatchedPoint>& points, const SE3& truth_T_estimate);

}  // namespace chasles
