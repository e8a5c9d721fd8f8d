#pragma once

#include <span>
#include <string>
#include <vector>

#include <chasles/filter/past.hpp>
#include <chasles/slam/body_state.hpp>

#include "participant.hpp"
#include "robot_slam.hpp"

namespace chasles::bridge {

struct BridgeOptions;

/// The frames of REP 105: map, odom, base.
struct Frames {
  std::string map, odom, base;
};

/// What the bridge publishes. Any thread may call.
class Outputs {
 public:
  Outputs(Participant& participant, const BridgeOptions& options);

  /// nav_msgs/msg/Odometry, and the transform from odom to base.
  void send(const BodyState& body, Time time);
  /// The transform from map to odom.
  void send_map(const SE3& map_T_odom, Time time);
  /// sensor_msgs/msg/PointCloud2 in the frame odom: x, y, z [m], sigma [m] (root of the trace of
  /// the covariance), each a float, and the number of observations as an unsigned integer.
  void send(std::span<const MapLandmark> landmarks, Time time);
  /// diagnostic_msgs/msg/DiagnosticArray, at the time of the system.
  void send(const app::RobotReport& report);

 private:
  void send_transform(const std::string& parent, const std::string& child,
                      const SE3& parent_T_child, Time time);

  Frames frames_;
  bool tf_;
  std::string name_;
  Writer<OdometryMessage> odometry_;
  Writer<TransformsMessage> transforms_;
  Writer<PointsMessage> points_;
  Writer<DiagnosticsMessage> diagnostics_;
};

/// What the diagnostics say of a run.
struct Diagnosis {
  enum Level : std::uint8_t { kOk = 0, kWarn = 1, kError = 2 };
  Level level = kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};
Diagnosis diagnose(const app::RobotReport& report);

}  // namespace chasles::bridge
