#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/eval/evaluation.hpp>

#include "drive.hpp"
#include "run_settings.hpp"

namespace chasles::app {

/// What a run is worth in one word: "lost" where it ended lost, "degraded" where more than a tenth
/// of the frames were, else "ok".
std::string run_health(const std::vector<RunState>& states);

/// The figures by name; what has no value is null.
nlohmann::ordered_json figures_json(const Evaluation& evaluation);

/// The run against its truth; what does not apply is null. A truth that cannot be compared
/// adds a remark.
nlohmann::ordered_json evaluation_json(const Run& run, const std::string& chart,
                                       std::vector<std::string>& remarks);

/// What every summary.json begins with: name, version, mode, chart, counts, figures.
nlohmann::ordered_json run_json(const Run& run, const std::string& mode, const std::string& chart,
                                const std::vector<TrueLandmark>& true_landmarks,
                                std::vector<std::string>& remarks);

/// `cameras` of summary.json (docs/formats.md): where the recording's cameras are on the IMU and
/// how wide they see, for the page to draw them.
nlohmann::ordered_json cameras_json(const Recording& recording);

/// summary.json: figures (design.md §6), settings, noise, version, remarks; nothing in it differs
/// between two runs of the same input and settings. Adds to the remarks as evaluation_json().
nlohmann::ordered_json summary_json(const Drive& drive, const DriveRunSettings& settings,
                                    const Recording& recording);

/// What of summary.json is known before the run: version, mode, chart, settings, cameras.
nlohmann::ordered_json known_json(const VelocitySlamSettings& settings, const Recording& recording);

/// seconds_wall, seconds_cpu and realtime_factor: what differs from run to run.
nlohmann::ordered_json timing_json(double recorded_seconds, double wall_seconds,
                                   double cpu_seconds);

/// The figures of a summary for a person, without settings.
std::string summary_text(const nlohmann::ordered_json& summary);

}  // namespace chasles::app
