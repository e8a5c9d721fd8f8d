#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/check/check_report.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// A time at rest.
struct Rest {
  Time begin{}, end{};
  Eigen::Vector3d specific_force_imu = Eigen::Vector3d::Zero();  ///< mean [m/s^2]
  Eigen::Vector3d angular_rate_imu = Eigen::Vector3d::Zero();    ///< mean: the bias [rad/s]
};

/// The times at rest, of at least a second: windows of half a second in which the specific force
/// deviates by less than 0.2 m/s^2 and the rate by less than 0.02 rad/s, with a mean rate below
/// 0.2 rad/s (which is a bias then), joined. (Scatter is the root of the three axes' variances.)
std::vector<Rest> find_rests(const std::vector<ImuSample>& imu);

/// Facts and findings: saturation (`range`: range_of the recording), samples that repeat the one
/// before, rests, and the size of gravity: at rest, or by the median of all samples where there is
/// none.
void report_imu(const std::vector<ImuSample>& imu, const ImuRange& range, CheckReport& report);

/// Whether gravity points down in the truth's world (fit_gravity).
void report_true_gravity(const Recording& recording, CheckReport& report);

/// At rest, which way is up for camera `index` (-y for one that stands upright).
void report_camera_upright(const Recording& recording, int index, CheckReport& report);

}  // namespace chasles
