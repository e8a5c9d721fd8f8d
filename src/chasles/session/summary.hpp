#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/estimator.hpp>
#include <chasles/session/recorded_run.hpp>
#include <chasles/session/velocity_settings_io.hpp>

// Content of summary.json and timing.json. Two runs with the same input and settings have the same
// summary.
namespace chasles {

nlohmann::ordered_json summary_json(const RecordedRun& run, const InertialRunSettings& settings,
                                    const InertialSensors& sensors, const Recording& recording);
/// `time_offset`: correction of the velocities' time stamps [s].
nlohmann::ordered_json summary_json(const RecordedRun& run, const VelocityCommandSettings& settings,
                                    const VelocitySensors& sensors, double time_offset,
                                    const Recording& recording);

/// The part of summary.json that is known before the run: version, mode, chart, settings, cameras.
nlohmann::ordered_json known_json(const InertialRunSettings& settings, const Recording& recording);
nlohmann::ordered_json known_json(const VelocityCommandSettings& settings,
                                  const Recording& recording);

/// Content of timing.json: figures that differ from run to run. Arguments are times in seconds.
nlohmann::ordered_json timing_json(const RecordedRun& run, double recorded_seconds,
                                   double wall_seconds, double cpu_seconds);

/// The figures and remarks of a summary as text, without settings.
std::string summary_text(const nlohmann::ordered_json& summary);

}  // namespace chasles
