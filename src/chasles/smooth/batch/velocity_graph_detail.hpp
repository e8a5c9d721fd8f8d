#pragma once

#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <chasles/smooth/batch/numbered_detail.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/terms/velocity_costs_detail.hpp>

/// The problem of a recording with body velocities as numbers: for this folder's sources alone.
namespace chasles::smooth_detail {

/// A look of the pair at a landmark.
struct StereoView {
  int keyframe = 0;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
};

/// A landmark: its views, keyframes rising, the first of them with a disparity. Anchored in the
/// left camera of the first view, parameters (x/z, y/z, 1/z), or a point of the world.
struct VelocityPoint {
  LandmarkId id = 0;
  std::vector<StereoView> views;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
};

/// An instant of a velocity, a frame, or both.
struct VelocityKeyframe {
  Time time{};
  VelocityState state;
  bool framed = false;  ///< a frame that is used was taken then
  int offered = 0;      ///< observations of it
  int used = 0;
};

/// The instants of a recording as they come, with what moves between them and what was measured of
/// the velocity; states are predicted.
class VelocityTimeline {
 public:
  /// Throws UsageError for settings that it does not take.
  VelocityTimeline(const VelocitySlamSettings& settings, const VelocitySlamNoise& noise);
  /// Throw InputError for time that runs backwards and velocities that are not finite. They return
  /// the keyframe of that instant.
  int add(const BodyVelocity& velocity);
  int add(const FeatureFrame& frame);
  /// What is older than that keyframe leaves.
  void forget_before(int keyframe);

  BodyVelocityModel model;
  DriveStart start;
  Numbered<VelocityKeyframe> keyframes = {};
  // Terms point at them.
  Numbered<TwistLink> links = {};  ///< between a keyframe and the next
  std::deque<DriveSample> samples = {};

 private:
  int advance_to(Time time, const BodyVelocity& held);

  VelocitySlamSettings settings_;
  BodyVelocityNoise noise_;
  std::optional<BodyVelocity> velocity_;
};

/// Throws UsageError or InputError where something that is measured has no noise.
void check_noise(const VelocityBatchInput& input);

/// The pixels of a frame that can be used: finite, every landmark once; by id. Counts the others.
std::vector<StereoObservation> usable(const FeatureFrame& frame, int& unusable);

/// Drops the views before the first one that tells a disparity of at least
/// VelocitySlamSettings::min_disparity; false: there is none.
bool begin_with_disparity(const StereoRig& rig, const VelocitySlamSettings& settings,
                          VelocityPoint& point);

/// Parameters as the first view has them; its keyframe's state must be there.
void place(const StereoRig& rig, bool anchored, const Numbered<VelocityKeyframe>& keyframes,
           VelocityPoint& point);

struct VelocityGraph {
  VelocityTimeline timeline;
  std::vector<VelocityPoint> points = {};
  bool anchored = true;
};

/// Keyframes with initial states, and landmarks with initial parameters. Counts into the report;
/// throws as smooth().
VelocityGraph velocity_graph(const VelocityBatchInput& input, const BatchSettings& settings,
                             BatchReport& report);

/// Takes those views out of the graph whose deviations are more than `gate`, and landmarks that are
/// left with one. Counts into the report; returns how many views went.
int cull(const VelocityBatchInput& input, const std::vector<double>& deviations, double gate,
         VelocityGraph& graph, BatchReport& report);

/// With batch.loss_width for this noise where it is auto. Measured noise of pixels stands for
/// errors that stay along a track and is 2.5 times what later looks scatter by, of which
/// Huber's 1.345 (1964) are 0.5; docs/batch.md, section 7, has what widths do.
BatchSettings with_loss_width(BatchSettings settings, const VelocitySlamNoise& noise);

/// The rows of a view, the landmark's first or a later one.
StereoRows view_rows(const VelocitySlamSettings& settings, bool first);
int row_count(StereoRows rows);

/// The graph's landmark as the filter's charts take it.
Landmark landmark_of(const StereoRig& rig, const VelocityPoint& point);

}  // namespace chasles::smooth_detail
