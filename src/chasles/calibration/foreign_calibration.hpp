#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibration/kalibr.hpp>

namespace chasles {

// Calibrations in the files of other programs, as the cameras and the IMU of a Kalibr calibration.
// docs/calibration-conventions.md has their conventions. Each reader takes the first `cameras`
// cameras, adds a remark with the file, and throws InputError that names the value that is missing.

/// VINS-Fusion's configuration (body_T_cam0, cam0_calib and its files beside it), or VINS-Mono's
/// (extrinsicRotation, extrinsicTranslation and the lens in the same file). Its noise is that of a
/// sample: KalibrCalibration::noise_of_samples.
KalibrCalibration read_vins(const std::filesystem::path& file, std::size_t cameras = kAllCameras);

/// ORB-SLAM3's settings with an IMU, by the new names of the keys (Camera1.fx, IMU.T_b_c1,
/// Stereo.T_c1_c2) or the old ones (Camera.fx, Tbc, Tlr, LEFT.K).
KalibrCalibration read_orb(const std::filesystem::path& file, std::size_t cameras = kAllCameras);

/// Basalt's calibration.json (value0), as headset recordings have it.
KalibrCalibration read_basalt(const std::filesystem::path& file, std::size_t cameras = kAllCameras);

/// The calibration of a Luxonis OAK camera as depthai writes it (cameraData, imuExtrinsics), left
/// camera first. It states no noise: `imu`, a file as Kalibr's imu.yaml, does.
KalibrCalibration read_depthai(const std::filesystem::path& file,
                               const std::optional<std::filesystem::path>& imu,
                               std::size_t cameras = kAllCameras);

/// The calibration of one such file, by its content; nothing of another one.
std::optional<KalibrCalibration> read_foreign_calibration(const std::filesystem::path& file,
                                                          std::size_t cameras = kAllCameras);

/// The only such file in the first of the places that has one, by its content; nothing without one.
/// Throws InputError for two in one place, and as the readers.
std::optional<KalibrCalibration> find_foreign_calibration(
    const std::vector<std::filesystem::path>& places, std::size_t cameras = kAllCameras);

/// The calibration of a rig in one of the places: Kalibr's or OpenVINS's files in any of them, else
/// another program's. A place is a folder, or its folder config, calib or calibration.
std::optional<KalibrCalibration> find_calibration(const std::vector<std::filesystem::path>& places,
                                                  std::size_t cameras = kAllCameras);

/// What is in the places and looks like a calibration, but does not suffice, as a sentence with
/// what to do; empty without it.
std::string insufficient_calibration(const std::vector<std::filesystem::path>& places);

}  // namespace chasles
