#pragma once

#include <string>
#include <vector>

#include <chasles/imu/join_imu.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// The samples of one sensor of an IMU whose accelerometer and gyroscope are read apart.
struct SensorStream {
  std::string name;  ///< for messages: a topic, or a file
  std::vector<AxesSample> samples;
};

/// Joins the two streams to recording.imu (ImuJoiner), whose range and noise are those of the
/// calibration; with a remark on rates and noise, and on what was left out. Each stream is put in
/// order of time first, and batches are spread (sample_batches.hpp). Where the range of the
/// accelerometer is not stated, it is the one that its own samples show (shown_range()). If the
/// gyroscope is the slower one, the noise density of the accelerometer is raised by
/// interpolated_noise().
///
/// `gyro_R_accel`: from the axes of the accelerometer to those of the gyroscope.
///
/// Throws InputError, starting with `where`: for a stream without samples or without finite ones,
/// for rates below 20 Hz or over a tenth of intervals longer than 50 ms, for samples that are means
/// over an interval, and if no instant has both.
void join_streams(const std::string& where, SensorStream forces, SensorStream rates,
                  const Eigen::Matrix3d& gyro_R_accel, Recording& recording);

}  // namespace chasles
