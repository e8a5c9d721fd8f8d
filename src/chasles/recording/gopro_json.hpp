#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/recording/split_imu.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {

/// The IMU of a GoPro as gopro-telemetry writes it (imu_data.json of UMI): an object with one
/// device, its `streams` ACCL and GYRO, and their `samples`, each with a `value` of three numbers
/// and `cts`, its time in milliseconds. The three are z, x, y, or as the stream's name has them in
/// brackets, and become x, y, z. Both sensors keep their own times.
///
/// `cts` is by the clock of the camera's stamps where there are any, so its zero is not the start
/// of the video. A stream with a sample for each picture (kStreamsOfPictures) leads to the clock of
/// the pictures; without one the first sample is at the first picture, as UMI has it.
struct GoproJson {
  SensorStream forces, rates;
};

/// Whether a file begins as one.
bool is_gopro_json(const std::filesystem::path& file);

/// Throws InputError with the file and the place in it: for a device without the two streams,
/// streams without samples, and values, times or units of another form. `pictures`: those of the
/// video, at least one.
GoproJson read_gopro_json(const std::filesystem::path& file,
                          const std::vector<VideoPicture>& pictures,
                          std::vector<std::string>& remarks);

}  // namespace chasles
