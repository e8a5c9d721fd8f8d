#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <xmlrpcpp/XmlRpcValue.h>

#include <chasles/lie/se3.hpp>
#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/reader_settings.hpp>

namespace chasles::ros1 {

/// The private parameters of the node (docs/ros.md). Those that are not listed here are settings,
/// with the names of `--set`: ~start/heading is start.heading.
struct NodeParameters {
  // Input
  std::filesystem::path calibration = {};  ///< needed
  std::string imu_topic = {};              ///< empty: as the calibration names it
  std::string accelerometer_topic = {};    ///< of its own; empty: imu_topic has both sensors
  std::vector<std::string> camera_topics = {};
  std::string image_transport = "raw";  ///< or "compressed"
  std::size_t cameras = kAllCameras;    ///< from "mono" and "stereo"
  int image_bits = 0;                   ///< in use, of 16-bit images; 0: as the first image shows
  // Estimation
  InertialRunSettings settings = {};
  std::filesystem::path map = {};
  bool lossless = false;
  int most_images = 3;
  // Output
  std::string name = "robot";
  std::filesystem::path save_map = {}, output = {};
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  std::string imu_frame = {};     ///< empty: header.frame_id of the samples
  std::optional<SE3> base_T_imu;  ///< none: by /tf_static
  bool publish_tf = true;
  double path_period = 1;    ///< [s]; 0: no path
  int path_length = 5000;    ///< most poses of the path: the latest
  double points_period = 1;  ///< [s]; 0: no points
};

/// Reads what the parameter server has below the node's name; a tree without entries may be
/// invalid. Throws UsageError for an unknown parameter, with the nearest name, for a value of
/// another type or range, and without `calibration`; as inertial_run_settings_from() for settings.
NodeParameters parameters_from(const XmlRpc::XmlRpcValue& tree);

}  // namespace chasles::ros1
