#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/imu/imu_sample.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// What an accelerometer shows of a truth's positions, at the attitudes of the truth.
struct TruthImuFit {
  /// The position at the stamp t of the truth is that of the IMU's time t - positions_late [s].
  double positions_late = 0, positions_late_sigma = 0;
  /// Of the attitudes against the positions about the vertical, to be added to the attitudes [rad]:
  /// that of the world, and that of the body's axes on average.
  double heading = 0, heading_sigma = 0;
  /// Of the vertical in the truth's world against its z axis [rad], and the sigma along the less
  /// certain horizontal axis.
  double tilt = 0, tilt_sigma = 0;
  /// The point on the body whose positions the truth has, in the axes of the IMU [m].
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), point_sigma = Eigen::Vector3d::Zero();
  int windows = 0;
};

/// Fits a truth to the samples of an IMU. A window has three positions half a second apart. Their
/// second difference is the integral of (0.5 s - |t - middle|) (R f + g) over the window, without
/// any velocity (as fit_gravity()). Free are the time of the positions, gravity's direction, the
/// heading, the point on the body, and as nuisance the accelerometer's bias, scale and axes.
/// Outliers count less (Cauchy); the sigmas come from the scores of 20 blocks in time (sandwich
/// estimator).
///
/// `attitudes_late`: the attitude at the stamp t is that of the IMU's time t - attitudes_late [s].
/// Windows with a gap of samples (0.05 s) or of the truth (`gap`) are left out. Returns nothing for
/// fewer than 20 windows, and where the motion does not determine the time to 20 ms.
std::optional<TruthImuFit> fit_truth_to_imu(const Trajectory& truth,
                                            const std::vector<ImuSample>& imu,
                                            double attitudes_late = 0, Time gap = kLongestTruthGap);

}  // namespace chasles
