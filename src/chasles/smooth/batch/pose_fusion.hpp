#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// What is known of the poses that an outside system measured, and of the IMU.
struct PoseFusionSettings {
  double position_sigma = 0.002;  ///< white, each axis of each pose [m]
  double rotation_sigma = 0.001;  ///< [rad]
  ImuNoise noise;
  ImuBuffer::Options imu = {};
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< roughly [m/s^2]
};

/// What poses and samples agree on.
struct PoseFusion {
  Trajectory world_T_imu;     ///< at the poses that samples cover and at the samples between them
  double position_moved = 0;  ///< of the poses, root mean square [m]
  double rotation_moved = 0;  ///< [rad]
  double cost_per_dof = 0;    ///< 1 where poses and samples err as stated
  int iterations = 0;
};

/// The most probable motion given poses that an outside system measured and the samples of an
/// IMU that is fixed to the same body: a truth that both agree on. Measured poses jitter against
/// the samples, which those of a camera that is fixed to the IMU cannot. Poses and samples are
/// weighted by their noise, over all of the time at once (terms of the batch estimator); a pose
/// that is far off counts less (Huber). Between two poses the samples tell, and what is left at the
/// end is spread evenly. `world_T_imu`: the world's z axis points up.
///
/// Throws InputError where the samples cover less than three seconds of the poses, or where either
/// has a gap of more than 0.5 s; Error(kDiverged) where no minimum is found.
PoseFusion fuse_poses(const Trajectory& world_T_imu, const std::vector<ImuSample>& samples,
                      const PoseFusionSettings& settings);

}  // namespace chasles
