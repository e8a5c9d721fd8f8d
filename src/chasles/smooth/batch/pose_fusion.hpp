#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// The noise of externally measured poses, and of the IMU.
struct PoseFusionSettings {
  double position_sigma = 0.002;  ///< white, per axis of each pose [m]
  double rotation_sigma = 0.001;  ///< the same of the rotation [rad]
  ImuNoise noise;
  ImuBuffer::Options imu = {};
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< initial value [m/s^2]
};

/// The fused motion.
struct PoseFusion {
  Trajectory world_T_imu;     ///< at the times of the poses that samples cover, and of the samples
                              ///< between them
  double position_moved = 0;  ///< RMS change of the poses [m]
  double rotation_moved = 0;  ///< the same of the rotations [rad]
  double cost_per_dof = 0;    ///< 1 where the stated noise of poses and samples is right
  int iterations = 0;
};

/// The most probable motion for externally measured poses and the samples of an IMU on the same
/// body: a ground truth that agrees with both. Measured poses jitter against the samples, but a
/// camera on the same rigid body as the IMU does not. Poses and samples are weighted by their
/// noise, over the whole time at once (terms of the batch estimator). A pose far off counts less
/// (Huber). Between two poses the samples are integrated, and the difference at the end is
/// distributed evenly. `world_T_imu`: the world's z axis points up.
///
/// Throws InputError where the samples cover less than three seconds of the poses, or where either
/// has a gap of more than 0.5 s; Error(kDiverged) where no minimum is found.
PoseFusion fuse_poses(const Trajectory& world_T_imu, const std::vector<ImuSample>& samples,
                      const PoseFusionSettings& settings);

}  // namespace chasles
