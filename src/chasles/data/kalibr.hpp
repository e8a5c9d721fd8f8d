#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The content of Kalibr's two files.
struct KalibrCalibration {
  std::vector<Camera> cameras = {};
  std::vector<std::string> camera_topics = {};  ///< of a ROS bag; empty where the file has none
  ImuNoise imu_noise = {};
  ImuRange imu_range = {};  ///< Kalibr has no such keys: accelerometer_range, gyroscope_range
  std::string imu_topic = {};
  std::vector<std::string> remarks = {};  ///< time shifts: they are not applied
};

/// Kalibr's files in a folder.
struct KalibrFiles {
  std::filesystem::path cameras;  ///< camchain-imucam.yaml
  std::filesystem::path imu;      ///< imu.yaml
};

/// Finds the files by name: `*camchain-imucam*.yaml` or OpenVINS's `kalibr_imucam_chain.yaml`, and
/// `imu*.yaml` or `kalibr_imu_chain.yaml`. Nothing if there is no camera file. Throws InputError if
/// there are two of a kind, or no IMU file.
std::optional<KalibrFiles> find_kalibr(const std::filesystem::path& folder);

/// Reads pinhole cameras with radtan, equidistant or no distortion. The extrinsics are T_cam_imu
/// (Kalibr: p_cam = T_cam_imu p_imu) or the inverse, T_imu_cam (OpenVINS). A later camera may have
/// T_cn_cnm1, the transform from the camera before it, instead. imu.yaml has the noise at its top
/// level, or below the key imu0. Throws InputError.
KalibrCalibration read_kalibr(const KalibrFiles& files);

}  // namespace chasles
