#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

// The files of an EuRoC recording (Burri et al. 2016), plain or gzip-compressed: tables whose first
// line is a comment with the names of the columns, and sensor.yaml. All throw InputError.

/// Whether these first bytes are those of an IMU table.
bool begins_euroc_imu(std::string_view bytes);

/// state_groundtruth_estimate0/data.csv: world_T_imu, velocity, gyroscope and accelerometer bias;
/// appended to the recording's truth and true motion. A table of 8 columns has poses alone.
void read_euroc_states(const std::filesystem::path& file, Recording& recording);

/// read_truth_of_recording(), with a remark that there are no velocities and biases.
void read_poses_alone(const std::filesystem::path& file, Recording& recording);

/// A camera of an EuRoC recording.
struct EurocCamera {
  Camera camera;
  Time time_offset{};  ///< added to its stamps, it gives the IMU's clock
  bool exact = false;  ///< its images are rendered with this calibration
};

/// cam0/sensor.yaml. Its T_BS maps camera coordinates to those of the body, which is the IMU. The
/// optional key timeshift_cam_imu is Kalibr's, and calibration_is_exact that of rendered
/// recordings; EuRoC's own files have neither.
EurocCamera read_euroc_camera(const std::filesystem::path& file);
/// The same for a camera whose tracks are read: their times are by the IMU's clock. Throws
/// InputError for a time offset.
Camera read_euroc_camera_of_tracks(const std::filesystem::path& file);

/// imu0/sensor.yaml; its T_BS must be the identity.
ImuNoise read_euroc_imu_noise(const std::filesystem::path& file);
/// The optional keys accelerometer_range and gyroscope_range of imu0/sensor.yaml. EuRoC's own files
/// do not have them.
ImuRange read_euroc_imu_range(const std::filesystem::path& file);

}  // namespace chasles
