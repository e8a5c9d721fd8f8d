#pragma once

#include <vector>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The motion of the IMU in its own axes.
struct PathMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();      ///< [rad/s]
};

/// At the i-th of at least two poses: from the pose before to the one after; at the ends of the
/// path from or to the pose itself.
PathMotion motion_at(const std::vector<SmoothedPose>& poses, std::size_t i);

}  // namespace chasles
