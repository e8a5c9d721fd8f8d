#pragma once

#include <filesystem>
#include <span>

#include <chasles/pipeline/visual_inertial_slam.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/run_recorder.hpp>

namespace chasles {

/// Writes the run folder of a robot's run: the files of `chasles run -o`, except prior_map.csv,
/// timing.json and those that need the truth. One thread.
class RobotLog {
 public:
  /// `sensors`: cameras and calibration alone. `settings` as given, `decided_settings` by
  /// decided(). The estimator must outlive the calls.
  RobotLog(Recording sensors, InertialRunSettings settings,
           const InertialRunSettings& decided_settings, const Estimator& estimator);
  RobotLog(const RobotLog&) = delete;
  RobotLog& operator=(const RobotLog&) = delete;

  void add(const FeatureFrame& frame) { recorder_.on_frame(frame); }
  void add(std::span<const Estimate> estimates);

  /// Writes the folder; summary.json has no figures of truth. Throws UsageError if it cannot be
  /// written.
  void write(const std::filesystem::path& folder) const;

 private:
  Recording sensors_;
  InertialRunSettings settings_;
  const Estimator& estimator_;
  RunRecorder recorder_;  ///< last, because it uses the others
};

}  // namespace chasles
