#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// A landmark whose position is known.
struct TrueLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m], in the frame of the true trajectory
};

/// What sensors delivered, and, where known, the truth. Times rise strictly within velocities,
/// frames and truth; every number is finite. The readers and the simulator see to that.
struct Recording {
  std::string name;
  StereoRig rig;
  std::vector<BodyVelocity> velocities;
  std::vector<FeatureFrame> frames;
  Trajectory truth;                          ///< world_T_imu; empty where unknown
  std::vector<TrueLandmark> true_landmarks;  ///< empty where unknown
  /// Standard deviations that the recording itself states; none where it does not.
  std::optional<BodyVelocitySigma> velocity_sigma;
  std::optional<Eigen::Vector4d> pixel_sigma;  ///< of (uL, vL, uR, vR) [px]
  /// What the reader corrected, dropped or counted, a sentence each, for the user to read.
  std::vector<std::string> remarks;
};

/// One thing that happened at a time.
using Event = std::variant<BodyVelocity, FeatureFrame>;

/// The recording in the order of time: a velocity comes before a frame of the same instant.
class EventStream {
 public:
  /// The recording must outlive the stream.
  explicit EventStream(const Recording& recording) : recording_(&recording) {}

  /// The next event; none at the end.
  std::optional<Event> next();

 private:
  const Recording* recording_;
  std::size_t velocity_ = 0;
  std::size_t frame_ = 0;
};

}  // namespace chasles
