#pragma once

#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <chasles/smooth/batch/numbered_detail.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/terms/velocity_costs_detail.hpp>

/// The states and terms of a batch problem with body velocities. Private to this folder.
namespace chasles::smooth_detail {

/// One observation of a landmark by the stereo pair.
struct StereoView {
  int keyframe = 0;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
};

/// A landmark: its views, sorted by keyframe, the first with a disparity. Either anchored in the
/// left camera of the first view, with parameters (x/z, y/z, 1/z), or a point of the world [m].
struct VelocityPoint {
  LandmarkId id = 0;
  std::vector<StereoView> views;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
};

/// An instant of a velocity, a frame, or both.
struct VelocityKeyframe {
  Time time{};
  VelocityState state;
  bool framed = false;  ///< whether it is the time of a used frame
  int offered = 0;      ///< observations of that frame
  int used = 0;
};

/// The instants of a recording as they arrive, with the links between them and the measurements of
/// the velocity; states are predicted.
class VelocityTimeline {
 public:
  /// Throws UsageError for unsupported settings.
  VelocityTimeline(const VelocitySlamSettings& settings, const VelocitySlamNoise& noise);
  /// Return the keyframe of that instant. Throw InputError for time that runs backwards and
  /// velocities that are not finite.
  int add(const BodyVelocity& velocity);
  int add(const FeatureFrame& frame);
  /// Removes what is older than that keyframe.
  void drop_before(int keyframe);

  BodyVelocityModel model;
  VelocityStart start;
  Numbered<VelocityKeyframe> keyframes = {};
  // Terms point at them.
  Numbered<TwistLink> links = {};  ///< between a keyframe and the next
  std::deque<VelocitySample> samples = {};

 private:
  int advance_to(Time time, const BodyVelocity& held);

  VelocitySlamSettings settings_;
  BodyVelocityNoise noise_;
  std::optional<BodyVelocity> velocity_;
};

/// Throws UsageError or InputError where a measurement has no noise.
void check_noise(const VelocityBatchInput& input);

/// The usable pixels of a frame: finite, every landmark once; sorted by id. Counts the others.
std::vector<StereoObservation> usable(const FeatureFrame& frame, int& unusable);

/// Drops the views before the first one with a disparity of at least
/// VelocitySlamSettings::min_disparity; false: there is none.
bool initialise_with_disparity(const StereoRig& rig, const VelocitySlamSettings& settings,
                               VelocityPoint& point);

/// Sets the parameters from the first view; the state of its keyframe must be there.
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

/// Removes the views with residuals above `gate` standard deviations, and landmarks with fewer than
/// two views left. Counts into the report; returns the number of removed views.
int cull(const VelocityBatchInput& input, const std::vector<double>& whitened_norms, double gate,
         VelocityGraph& graph, BatchReport& report);

/// Sets batch.loss_width for this noise where it is auto. Measured pixel noise includes errors that
/// stay along a track. It is 2.5 times the scatter of later observations, so that Huber's 1.345
/// (1964) becomes 0.5. studies/batch.md compares widths.
BatchSettings with_loss_width(BatchSettings settings, const VelocitySlamNoise& noise);

/// The rows of a view, the landmark's first or a later one.
StereoRows view_rows(const VelocitySlamSettings& settings, bool first);
int row_count(StereoRows rows);

/// The graph's landmark in the form of the filter's charts.
Landmark landmark_of(const StereoRig& rig, const VelocityPoint& point);

}  // namespace chasles::smooth_detail
