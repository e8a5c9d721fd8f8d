#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// A rotation from the IMU's axes to those of a vehicle, forward, right and down (FRD): the three
/// as axes of the IMU. "x,-y,-z" is an IMU whose x axis is forward and z up. Throws UsageError for
/// a text that is no such rotation.
Eigen::Matrix3d frd_R_imu(std::string_view axes);

/// The state of a vehicle as autopilots take it. The local frame has the run's x axis forward, and
/// y right, z down; the body is at the IMU, with the axes of the vehicle.
struct FrdOdometry {
  Time time{};
  SE3 local_T_body = {};
  Eigen::Vector3d v_body = Eigen::Vector3d::Zero();     ///< [m/s]
  Eigen::Vector3d rate_body = Eigen::Vector3d::Zero();  ///< [rad/s]
  /// Of [position along local axes; rotation about body axes] [m, rad].
  Matrix6d pose_covariance = Matrix6d::Zero();
  /// Of v_body, without its correlation with the attitude; none where the path does not have it.
  std::optional<Eigen::Matrix3d> velocity_covariance = {};
  std::uint8_t resets = 0;       ///< after a loss and after each loop closure one more, modulo 256
  std::string_view health = {};  ///< "ok", "degraded", "lost"; empty where the path does not say it
};

/// The states of a path. Velocities are those of states.csv; on the smoothed path they follow from
/// the positions, as all rates from the attitudes. Throws InputError as path_poses(), for a run
/// without an IMU, whose world is not level, and for a path of one pose.
std::vector<FrdOdometry> frd_odometry(const ReportRun& run, RunPath path,
                                      const Eigen::Matrix3d& body_R_imu);

}  // namespace chasles
