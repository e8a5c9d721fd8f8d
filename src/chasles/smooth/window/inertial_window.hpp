#pragma once

#include <memory>
#include <string>
#include <vector>

#include <chasles/slam/health.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

namespace chasles {

struct InertialWindowResult {
  std::vector<Estimate> estimates;     ///< of all frames that are keyframes
  std::vector<MapLandmark> landmarks;  ///< as they were when they left the window, then its own
  std::vector<LandmarkId> in_window;   ///< those that the next frame might still touch
  WindowReport report;
};

/// A recording with an IMU through a window of so many keyframes that slides over it: the most
/// probable motion and landmarks of the last keyframes, relinearised with every frame, given all
/// samples and frames so far; what has left the window stays as a Gaussian prior (docs/window.md).
/// The terms are those of smooth() of batch.hpp. An estimate depends on nothing that comes later
/// than the first sample at or after its frame.
///
/// Of `input` all but samples, frames and initial states is taken. Recovered and counted: see
/// WindowReport. Throws as that smooth() does, except for what is ill-posed: then the covariance
/// says so; UsageError for fewer than two keyframes; Error(kDiverged) where a step finds nothing
/// finite.
class InertialWindow {
 public:
  InertialWindow(const InertialBatchInput& input, const std::string& chart,
                 const BatchSettings& settings, int keyframes);
  ~InertialWindow();

  /// The estimates of the frames that waited for this sample, or that waited for none. A frame
  /// waits until there is a sample at its time or later.
  std::vector<Estimate> process(const ImuSample& sample);
  std::vector<Estimate> process(const FeatureFrame& frame);
  /// Those of the frames that still wait: no more samples will come.
  std::vector<Estimate> finish();
  bool waiting() const;  ///< a frame does

  /// Landmarks as they were when they left the window, then those that are in it.
  std::vector<MapLandmark> map() const;
  /// The landmarks that the next frame may still touch.
  std::vector<LandmarkId> in_window() const;
  Eigen::Vector3d gyroscope_bias() const;  ///< the newest keyframe's [rad/s]
  const WindowReport& report() const;
  /// At the end: throws InputError where no landmark was seen twice.
  void check() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> of_;
};

/// All of a recording through such a window.
InertialWindowResult slide(const InertialBatchInput& input, const std::string& chart,
                           const BatchSettings& settings, int keyframes);

}  // namespace chasles
