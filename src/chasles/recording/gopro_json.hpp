#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/recording/split_imu.hpp>

namespace chasles {

/// The IMU of a GoPro as gopro-telemetry writes it (imu_data.json of UMI): an object with one
/// device, its `streams` ACCL and GYRO, and their `samples`, each with a `value` of three numbers
/// and `cts`, the milliseconds since the start of the video. The three are z, x, y, or as the
/// stream's name has them in brackets, and become x, y, z. Both sensors keep their own times.
struct GoproJson {
  SensorStream forces, rates;
};

/// Whether a file begins as one.
bool is_gopro_json(const std::filesystem::path& file);

/// Throws InputError with the file and the place in it: for a device without the two streams,
/// streams without samples, and values, times or units of another form.
GoproJson read_gopro_json(const std::filesystem::path& file, std::vector<std::string>& remarks);

}  // namespace chasles
