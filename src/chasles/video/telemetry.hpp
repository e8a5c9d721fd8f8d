#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/imu/join_imu.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {

/// The samples of a GoPro's IMU, by the clock of its video: each sensor at its own times.
struct Telemetry {
  std::vector<AxesSample> forces;  ///< [m/s^2]
  std::vector<AxesSample> rates;   ///< [rad/s]
};

/// Reads the accelerometer (ACCL) and the gyroscope (GYRO) of the payloads in a video (gpmf.hpp).
///
/// Axes: GoPro's X, Y, Z, for cameras of all models: seen from behind the camera X points to the
/// left, Y to whoever looks at its back, and Z up. Where a stream states the axes of its channels
/// (ORIN, or MTRX with ORIO), they count; a matrix may also have a calibration. Streams without a
/// statement, as those of HERO5 to 7, have the order Z, X, Y that their names state.
///
/// Times: where the streams are stamped (STMP), a sample is between the stamps of the payloads
/// around it. The stamps' clock is that of the pictures by a stream that has one sample for each
/// picture, or for every n-th (kStreamsOfPictures): offset and rate of the straight line
/// through its stamps. Without such a stream the first stamp of the two sensors is at the start of
/// its payload. Streams without stamps (HERO5, 6) have the numbers of their samples (TSMP) at the
/// starts of the payloads: the straight line through them, because a payload takes what has come by
/// then. A delay (TIMO) is subtracted. An offset between the two sensors stays.
///
/// Damaged payloads are left out, with a remark. Throws InputError, with the file's name: if all
/// are damaged, if one of the two sensors is missing or has no three axes, and for units other than
/// m/s^2, g, rad/s and deg/s.
Telemetry read_telemetry(const VideoIndex& index, std::vector<std::string>& remarks);

}  // namespace chasles
