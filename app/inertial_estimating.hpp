#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

#include "inertial_setup.hpp"

namespace chasles::app {

/// What batch estimation and windows begin with: the first estimate, of which no landmark is a part
/// yet. Without samples and frames.
InertialBatchInput smoothing_input(const Recording& recording, const InertialRunSettings& settings,
                                   const InertialDrive& drive, const InertialEstimate& first);

/// What goes through a recording with an IMU, event by event: the filter from its start to its end,
/// or a window, for which the filter's session only finds the start.
class InertialEstimating {
 public:
  /// The references must outlive it.
  InertialEstimating(const Recording& recording, const InertialRunSettings& settings,
                     const InertialDriveOptions& options, const InertialDrive& drive);

  /// The estimates that an event brings: see InertialSession and InertialWindow.
  std::vector<InertialEstimate> process(const ImuSample& sample);
  std::vector<InertialEstimate> process(const FeatureFrame& frame);
  std::vector<InertialEstimate> finish();

  /// The filter's, which finds the start; where a window has begun it stands still.
  InertialSession& session() { return session_; }
  bool running() const { return session_.running(); }

  Eigen::Vector3d gyroscope_bias() const;
  std::vector<MapLandmark> map() const;
  std::vector<LandmarkId> in_state() const;
  /// At the end: the map and what was counted. Throws as InertialWindow::check(), unless the run
  /// was interrupted.
  void report(InertialDrive& drive) const;

 private:
  std::vector<InertialEstimate> begin(const InertialEstimate& first);

  const Recording& recording_;
  const InertialRunSettings& settings_;
  const InertialDrive& drive_;
  int keyframes_;  // of the window; 0: the filter
  InertialSession session_;
  std::optional<InertialWindow> window_;
  // That came before there was a start.
  std::vector<ImuSample> samples_;
  std::vector<FeatureFrame> frames_;
};

}  // namespace chasles::app
