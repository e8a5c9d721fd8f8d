#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <chasles/lie/se3.hpp>

namespace chasles {

/// A landmark as it was estimated and as it is.
struct MatchedPoint {
  Eigen::Vector3d p_estimate = Eigen::Vector3d::Zero();  ///< in the estimate's world [m]
  Eigen::Vector3d p_truth = Eigen::Vector3d::Zero();     ///< in the truth's world [m]
};

/// How far landmarks are from where they should be.
struct LandmarkError {
  std::size_t count = 0;
  double rmse_first_pose_m = 0;          ///< the worlds brought together by the first poses
  std::optional<double> rmse_aligned_m;  ///< by least squares over the landmarks; from 3 on
};

/// `truth_T_estimate` relates the worlds by the first poses; without points all is zero.
LandmarkError landmark_error(const std::vector<MatchedPoint>& points, const SE3& truth_T_estimate);

}  // namespace chasles
