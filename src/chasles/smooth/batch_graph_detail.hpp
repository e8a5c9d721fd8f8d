#pragma once

#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch.hpp>
#include <chasles/smooth/imu_link.hpp>

/// The problem as numbers: for this folder's sources alone.
namespace chasles::smooth_detail {

/// A look at a landmark.
struct PointView {
  int keyframe = 0, camera = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A landmark: its views, keyframe and camera rising. Anchored in the camera of the first view,
/// parameters (x/z, y/z, 1/z), or a point of nav.
struct BatchPoint {
  LandmarkId id = 0;
  std::vector<PointView> views;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
};

struct BatchKeyframe {
  Time time{};  ///< of the IMU's clock
  InertialState state = {};
  int observations = 0;
};

struct BatchGraph {
  std::vector<BatchKeyframe> keyframes;
  std::vector<ImuLink> links = {};  ///< between a keyframe and the next
  std::vector<BatchPoint> points = {};
  InertialState start = {};                            ///< the prior's mean
  Matrix15d start_whitening = Matrix15d::Identity();   ///< W^T W = covariance^-1
  Matrix15d start_covariance = Matrix15d::Identity();  ///< with the floors of BatchInput
  Eigen::Vector3d gravity = {0, 0, -kStandardGravity};
  bool anchored = true;
};

/// Samples that are missing for longer leave open what happened (as for the filter).
inline constexpr Time kLongestGap = InertialSession::kLongestGap;

/// The frames that become keyframes, the start before them, without states, and the landmarks that
/// they see twice, by their first views, without parameters. Counts what is not usable.
struct Tracked {
  std::vector<BatchKeyframe> keyframes;
  std::vector<BatchPoint> points;
};
Tracked track(const BatchInput& input, const BatchSettings& settings, Time last_sample,
              BatchReport& report);

/// Keyframes with initial states, links, and landmarks with initial parameters. Counts into the
/// report; throws as smooth().
BatchGraph batch_graph(const BatchInput& input, const BatchSettings& settings, BatchReport& report);

/// The graph's landmark as the filter's charts and measurements take it.
Clone anchor_of(const BatchGraph& graph, const BatchPoint& point);
Landmark landmark_of(const Camera& anchor_camera, const BatchPoint& point);

/// The errors [rotation, position, velocity, biases] of a state against the prior's mean, reference
/// chart, whitened; and the derivative by the state's own errors.
Vector15d start_residual(const BatchGraph& graph, const InertialState& state,
                         Matrix15d* derivative);

}  // namespace chasles::smooth_detail
