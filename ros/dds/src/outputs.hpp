#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <string>

#include <chasles/robot/robot_diagnosis.hpp>
#include <chasles/robot/state_stream.hpp>

#include "participant.hpp"
#include "px4.hpp"

namespace chasles::bridge {

struct BridgeOptions;

/// The frames of REP 105: map, odom, base.
struct Frames {
  std::string map, odom, base;
};

/// What the bridge publishes. Any thread may call.
class Outputs : public StateSink {
 public:
  Outputs(Participant& participant, const BridgeOptions& options);

  /// nav_msgs/msg/Odometry, the transform from odom to base and, with a topic for it,
  /// px4_msgs/msg/VehicleOdometry.
  void odometry(const BodyState& body, Time time) override;
  /// For the field of PX4's message.
  void quality(Health health, std::size_t jumps) override;
  /// The transform from map to odom.
  void map_T_odom(const SE3& pose, Time time) override;
  /// sensor_msgs/msg/PointCloud2 in the frame odom: x, y, z [m], sigma [m] (root of the trace of
  /// the covariance), each a float, and the number of observations as an unsigned integer.
  void points(std::span<const MapLandmark> landmarks, Time time) override;
  /// diagnostic_msgs/msg/DiagnosticArray, at the time of the system.
  void send(RobotDiagnosis diagnosis);

 private:
  void send_transform(const std::string& parent, const std::string& child,
                      const SE3& parent_T_child, Time time);

  Frames frames_;
  bool tf_;
  std::string name_;
  std::atomic<Px4Quality> quality_ = Px4Quality{};  ///< of the last estimate
  Writer<OdometryMessage> odometry_writer_;
  std::optional<Writer<VehicleOdometryMessage>> px4_writer_;
  Writer<TransformsMessage> transform_writer_;
  Writer<PointsMessage> points_writer_;
  Writer<DiagnosticsMessage> diagnostics_writer_;
};

}  // namespace chasles::bridge
