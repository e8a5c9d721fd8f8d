#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/check/check_report.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// A standstill: an interval in which the IMU shows no motion.
struct StandstillSpan {
  Time begin{}, end{};
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< mean [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();  ///< mean, the gyroscope bias [rad/s]
};

/// The standstills of at least a second. They consist of windows of half a second in which the
/// specific force scatters by less than 0.2 m/s^2 and the rate by less than 0.02 rad/s, and the
/// mean rate, then a bias, is below 0.2 rad/s. The scatter is the root of the sum of the three
/// axes' variances.
std::vector<StandstillSpan> find_standstills(const std::vector<ImuSample>& imu);

/// Whether all samples are six zeros: the topic of a driver that fills in the attitude alone.
bool has_no_measurement(const std::vector<ImuSample>& imu);

/// Facts and findings: saturation (`range`: range_of() the recording), samples that repeat the one
/// before, axes that show one number only, standstills, and the magnitude of gravity: during the
/// longest standstill, or without one from the median of all samples. Samples that are all zero
/// give one finding.
void report_imu(const std::vector<ImuSample>& imu, const ImuRange& range, CheckReport& report);

/// Roll and pitch of camera `index` during a standstill (up is -y for an upright camera), and a
/// finding where it is upside down.
void report_camera_upright(const Recording& recording, int index, CheckReport& report);

}  // namespace chasles
