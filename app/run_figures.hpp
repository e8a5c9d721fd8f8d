#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/eval/evaluation.hpp>

// The figures of a run, as summary.json has them.
namespace chasles::app {

/// What a run is worth in one word: "lost" where it ended lost, "degraded" where more than a tenth
/// of the frames were, else "ok".
std::string run_health(const std::vector<RunState>& states);

/// The figures by name; what has no value is null.
nlohmann::ordered_json figures_json(const Evaluation& evaluation);

/// The run against its truth; what does not apply is null. A truth that cannot be compared adds a
/// remark.
nlohmann::ordered_json evaluation_json(const Run& run, const std::string& chart,
                                       std::vector<std::string>& remarks);

/// What every summary.json begins with: name, version, mode, chart, counts, figures.
nlohmann::ordered_json run_json(const Run& run, const std::string& mode, const std::string& chart,
                                const std::vector<TrueLandmark>& true_landmarks,
                                std::vector<std::string>& remarks);

/// `cameras` of summary.json (docs/formats.md): where the recording's cameras are on the IMU and
/// how wide they see, for the page to draw them.
nlohmann::ordered_json cameras_json(const Recording& recording);

}  // namespace chasles::app
