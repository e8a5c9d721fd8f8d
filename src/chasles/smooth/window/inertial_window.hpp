#pragma once

#include <memory>
#include <string>
#include <vector>

#include <chasles/estimate/health.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

struct InertialWindowResult {
  std::vector<Estimate> estimates;     ///< of all frames that are keyframes
  std::vector<MapLandmark> landmarks;  ///< as they were when they left the window, then those in it
  std::vector<LandmarkId> in_window;   ///< those that the next frame may still change
  WindowReport report;
};

/// A sliding window of the last N keyframes of a recording with an IMU. It estimates the most
/// probable motion and landmarks of these keyframes, relinearised with every frame, from all
/// samples and frames so far. Older states are marginalised into a Gaussian prior (docs/window.md).
/// The terms are those of smooth() of batch.hpp. An estimate does not depend on data after the
/// first sample at or after its frame.
///
/// Uses all of `input` but samples, frames and initial states. Recovered and counted: see
/// WindowReport. Throws as that smooth(), but not for ill-posed problems, which show in the
/// covariance. UsageError for fewer than two keyframes; Error(kDiverged) where a step finds no
/// finite cost.
class InertialWindow {
 public:
  InertialWindow(const InertialBatchInput& input, const std::string& chart,
                 const BatchSettings& settings, int keyframes);
  ~InertialWindow();

  /// The estimates of the frames that waited for this sample, which a SampleScreen has released. A
  /// frame waits until there is a sample at its time or later.
  std::vector<Estimate> process(const ImuSample& measured);
  std::vector<Estimate> process(const FeatureFrame& frame);
  /// The estimates of the frames that still wait; no more samples come.
  std::vector<Estimate> finish();
  bool waiting() const;  ///< whether a frame does

  /// Landmarks as they were when they left the window, then those in it.
  std::vector<MapLandmark> map() const;
  /// The landmarks that the next frame may still change.
  std::vector<LandmarkId> in_window() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< of the newest keyframe [rad/s]
  const WindowReport& report() const;
  /// At the end: throws InputError where no landmark was observed twice.
  void check() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> of_;
};

/// Runs such a window over a whole recording, whose samples it screens.
InertialWindowResult slide(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, int keyframes);

}  // namespace chasles
