#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/visual_inertial_slam.hpp>
#include <chasles/recording/recording.hpp>

#include "observation_spans.hpp"

namespace chasles::app {

/// What the run folder of a robot's run needs of its estimates: the files of `chasles run -o`,
/// except those that need the truth.
class RobotLog {
 public:
  /// `sensors`: cameras and calibration alone. `settings` as given, `decided_settings` by
  /// decided().
  RobotLog(Recording sensors, InertialRunSettings settings,
           const InertialRunSettings& decided_settings, const Estimator& estimator);

  void add(const FeatureFrame& frame);
  void add(std::span<const Estimate> estimates);

  /// Writes the folder; summary.json has no figures of truth. Throws UsageError if it cannot be
  /// written.
  void write(const Estimator& estimator, const std::filesystem::path& folder) const;

 private:
  Recording sensors_;
  InertialRunSettings settings_;
  Run run_;
  ObservationSpans spans_;
  std::map<Degradation, int> degradations_;
  std::optional<Time> first_frame_, last_frame_;
  std::optional<double> start_seconds_, initialised_seconds_;
  std::size_t frames_ = 0, before_start_ = 0, estimated_ = 0;
  int zupt_frames_ = 0;
  std::optional<Calibration> calibration_;
};

}  // namespace chasles::app
