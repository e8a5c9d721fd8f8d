#pragma once

#include <memory>
#include <optional>

#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

/// A sliding window of the last N keyframes of a recording with body velocities and a stereo pair.
/// It estimates the most probable motion and landmarks of these keyframes, relinearised with every
/// frame, from all velocities and frames so far. Older states are marginalised into a Gaussian
/// prior (docs/window.md). Feed it as VelocitySlam; the terms are those of smooth() of
/// velocity_batch.hpp.
///
/// Uses rig, settings and noise of `input`. Throws as that smooth(), also for velocities that are
/// not finite and for time that runs backwards; UsageError for a window of fewer than two
/// keyframes.
class VelocityWindow {
 public:
  VelocityWindow(const VelocityBatchInput& input, const BatchSettings& settings, int keyframes);
  ~VelocityWindow();

  void process(const BodyVelocity& velocity);
  /// The estimate at the frame's time, which is the window's newest keyframe, and its covariance,
  /// from all data so far. None for a frame between keyframes (batch.frames_per_keyframe).
  /// Estimates after Health::kLost are meaningless.
  std::optional<Estimate> process(const FeatureFrame& frame);

  /// Landmarks as they were when they left the window, then those in it.
  std::vector<MapLandmark> map() const;
  /// The landmarks that the next frame may still change.
  std::vector<LandmarkId> in_window() const;
  const WindowReport& report() const;
  /// At the end: throws InputError where no landmark was observed twice.
  void check() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> of_;
};

}  // namespace chasles
