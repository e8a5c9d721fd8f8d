#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibration/all_cameras.hpp>
#include <chasles/calibration/imu_intrinsics.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The content of Kalibr's two files.
struct KalibrCalibration {
  std::vector<Camera> cameras = {};
  /// For each camera: added to its stamps, it gives the IMU's clock (timeshift_cam_imu).
  std::vector<Time> time_offsets = {};
  std::vector<std::string> camera_topics = {};  ///< of a ROS bag; empty where the file has none
  ImuNoise imu_noise = {};
  /// Whether the noise is the standard deviation of a sample, and of the bias' step from a sample
  /// to the next per second, as VINS has it: densities_of_samples() makes densities of it.
  bool noise_of_samples = false;
  ImuRange imu_range = {};  ///< Kalibr has no such keys: accelerometer_range, gyroscope_range
  std::optional<ImuIntrinsics> imu_intrinsics = {};
  std::string imu_topic = {};
  double imu_rate = 0;                    ///< [Hz], as the file states it; 0: it does not
  std::filesystem::path file = {};        ///< of the cameras, if it is Kalibr's or OpenVINS's
  std::vector<std::string> remarks = {};  ///< on the choice of the files, and on what they state
};

/// Kalibr's files in a folder.
struct KalibrFiles {
  std::filesystem::path cameras;          ///< camchain-imucam.yaml
  std::filesystem::path imu;              ///< imu.yaml
  std::vector<std::string> remarks = {};  ///< on files that are not taken
};

/// Finds the files by name; the ending is .yaml or .yml.
///
/// Cameras: the result of kalibr_calibrate_imu_camera (`*camchain-imucam*`) or OpenVINS's
/// `kalibr_imucam_chain`, else `*camchain*`, which may hold T_cam_imu as well; else OpenVINS's name
/// with a suffix, `kalibr_imucam_chain*`. IMU: with `X-camchain-imucam` or `camchain-imucam-X` the
/// file `X-imu` or `imu-X`, and with `kalibr_imucam_chainX` the file `kalibr_imu_chainX`; else a
/// result of Kalibr (`*-imu`, `imu-*`) or OpenVINS's `kalibr_imu_chain`, else `imu*`, Kalibr's
/// input.
///
/// Nothing if there is no camera file. Throws InputError if there are two that are equally good, or
/// no IMU file.
std::optional<KalibrFiles> find_kalibr(const std::filesystem::path& folder);

/// Reads the first `cameras` cameras, with a lens as read_kalibr_lens() reads it (lens.hpp). The
/// extrinsics are T_cam_imu (Kalibr: p_cam = T_cam_imu p_imu) or the inverse, T_imu_cam (OpenVINS).
/// A later camera may have T_cn_cnm1, the transform from the camera before it, instead. imu.yaml
/// has the noise at its top level, or below the key imu0. Throws InputError.
KalibrCalibration read_kalibr(const KalibrFiles& files, std::size_t cameras = kAllCameras);

/// The cameras of such a file alone, without the IMU's. Where the first camera has neither
/// T_cam_imu nor T_imu_cam, as kalibr_calibrate_cameras writes it, cam_T_imu is cam_T_cam0. Throws
/// InputError.
KalibrCalibration read_kalibr_cameras(const std::filesystem::path& file);

/// The IMU's file alone, found by the same names.
std::optional<std::filesystem::path> find_kalibr_imu(const std::filesystem::path& folder);
/// Its noise, ranges, intrinsics and topic; the calibration has no cameras.
KalibrCalibration read_kalibr_imu(const std::filesystem::path& file);

/// The time offset that the key `timeshift_cam_imu` states; zero without it. Throws InputError.
Time read_time_offset(const YamlMap& map);

/// A remark on each camera whose time offset is not zero.
void remark_on_time_offsets(const std::vector<Time>& offsets, std::vector<std::string>& remarks);

}  // namespace chasles
