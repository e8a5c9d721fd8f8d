#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/lie/se3.hpp>
#include <chasles/robot/robot_slam.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace CLI {
class App;
}

namespace chasles::bridge {

/// The command line of chasles_dds.
struct BridgeOptions {
  // Input
  std::filesystem::path calibration;
  std::string imu;            ///< topic; empty: that of the calibration, or /imu0
  std::string accelerometer;  ///< topic of its own; empty: none. `imu` is the gyroscope's then
  std::vector<std::string>
      cameras;         ///< topics; empty: those of the calibration, or /camN/image_raw
  int image_bits = 0;  ///< in use, of 16-bit images; 0: as the first one shows
  // Network
  std::optional<int> domain;  ///< none: that of ROS_DOMAIN_ID, or 0
  std::string network;        ///< empty: that of CYCLONEDDS_URI, or loopback
  bool reliable = false;
  // Estimation
  SettingSources settings;
  std::string estimator = "filter";
  RobotSetup robot;  ///< all but its calibration and settings
  // Output
  std::string map_frame = "map", odom_frame = "odom", base_frame = "base_link";
  std::string base_T_imu_text;  ///< empty: the identity
  std::string odometry = "/odometry", points = "/points", diagnostics = "/diagnostics";
  std::string px4;              ///< topic of PX4's VehicleOdometry; empty: none
  std::string rate = "images";  ///< of the odometry; or "samples"
  bool tf = true;
  double points_period = 1;    ///< [s]; 0: no points
  std::optional<double> idle;  ///< ends after so long without a message [s]; none: runs on
  bool quiet = false;
};

/// Adds them to the parser, with the help on settings. `options` must outlive it.
void declare_bridge_options(CLI::App& parser, BridgeOptions& options);

/// What follows from them.
struct BridgeNetwork {
  int domain = 0;
  std::string configuration;  ///< of Cyclone DDS; empty: that of the environment
};
/// Throws UsageError for a domain that does not exist, and as network_configuration().
BridgeNetwork network_of(const BridgeOptions& options);

/// "x,y,z,qx,qy,qz,qw". Throws UsageError for another text.
SE3 base_T_imu_of(const BridgeOptions& options);

/// Checks the options that no parser checks. Throws UsageError.
void check(const BridgeOptions& options);

}  // namespace chasles::bridge
