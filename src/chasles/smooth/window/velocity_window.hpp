#pragma once

#include <memory>
#include <optional>

#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

/// A recording with body velocities and a stereo pair through a window that slides over it: the
/// most probable motion and landmarks of the last keyframes, relinearised with every frame, given
/// all velocities and frames so far; what has left the window stays as a Gaussian prior
/// (docs/window.md). Fed as VelocitySlam is; the terms are those of smooth() of velocity_batch.hpp.
///
/// Of `input` rig, settings and noise are taken. Throws as that smooth(), for velocities that are
/// not finite and time that runs backwards as well; UsageError for a window of fewer than two
/// keyframes.
class VelocityWindow {
 public:
  VelocityWindow(const VelocityBatchInput& input, const BatchSettings& settings, int keyframes);
  ~VelocityWindow();

  void process(const BodyVelocity& velocity);
  /// The estimate of the frame's instant, which is the window's newest keyframe, and its
  /// covariance, given all that came until now. None for a frame between keyframes
  /// (batch.frames_per_keyframe). Nothing after Health::kLost counts.
  std::optional<Estimate> process(const FeatureFrame& frame);

  /// Landmarks as they were when they left the window, then those that are in it.
  std::vector<MapLandmark> map() const;
  /// The landmarks that the next frame may still touch.
  std::vector<LandmarkId> in_window() const;
  const WindowReport& report() const;
  /// At the end: throws InputError where no landmark was seen twice.
  void check() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> of_;
};

}  // namespace chasles
