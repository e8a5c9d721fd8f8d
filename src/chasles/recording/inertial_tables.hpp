#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/codec/csv.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

// The tables of a recording folder for an IMU and single cameras (docs/formats.md). Reading throws
// InputError with file, line and column.

extern const std::vector<std::string> kImuColumns;  ///< of imu.csv

/// The finite numbers of that column and the two columns after it.
Eigen::Vector3d vector_at(const CsvReader& csv, std::size_t column);

/// All rows; times rise strictly. The numbers may be "nan" or "inf": leave_out_not_finite() of
/// image_recording.hpp removes such samples.
std::vector<ImuSample> read_imu(const std::filesystem::path& file);
void write_imu(const std::vector<ImuSample>& imu, const std::filesystem::path& file);

/// Adds the rows of pixels.csv, which are in order of time, to the frames. `cameras`: the number of
/// calibrated cameras.
void read_pixels(const std::filesystem::path& file, std::size_t cameras,
                 std::vector<FeatureFrame>& frames);
void write_pixels(const std::vector<FeatureFrame>& frames, const std::filesystem::path& file);

/// One row for each pose of the truth, at its time.
std::vector<TrueMotion> read_true_motion(const std::filesystem::path& file,
                                         const Trajectory& truth);
void write_true_motion(const std::vector<TrueMotion>& motion, const std::filesystem::path& file);

}  // namespace chasles
