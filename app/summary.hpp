#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/estimator.hpp>

#include "run_recording.hpp"

// What summary.json and timing.json say of a run. Of the summary nothing differs between two runs
// of the same input and settings.
namespace chasles::app {

nlohmann::ordered_json summary_json(const RecordedRun& run, const InertialRunSettings& settings,
                                    const InertialSensors& sensors, const Recording& recording);
/// `time_offset`: by which the velocities' stamps were corrected [s].
nlohmann::ordered_json summary_json(const RecordedRun& run, const VelocityRunSettings& settings,
                                    const VelocitySensors& sensors, double time_offset,
                                    const Recording& recording);

/// What of summary.json is known before the run: version, mode, chart, settings, cameras.
nlohmann::ordered_json known_json(const InertialRunSettings& settings, const Recording& recording);
nlohmann::ordered_json known_json(const VelocityRunSettings& settings, const Recording& recording);

/// timing.json: what differs from run to run.
nlohmann::ordered_json timing_json(const RecordedRun& run, double recorded_seconds,
                                   double wall_seconds, double cpu_seconds);

/// The figures of a summary for a person, without settings.
std::string summary_text(const nlohmann::ordered_json& summary);

}  // namespace chasles::app
