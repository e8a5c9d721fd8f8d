#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/eval/evaluation.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/coverage.hpp>

// The figures of a run for summary.json.
namespace chasles {

/// Health of a run: "lost" if its last frame is lost; "degraded" if any frame is lost, more than a
/// tenth are degraded, or the coverage is below kLeastCoverage; otherwise "ok".
std::string run_health(const std::vector<RunState>& states, const FrameCoverage& coverage);

/// The figures by name; a figure without a value is null.
nlohmann::ordered_json figures_json(const Evaluation& evaluation);

/// Evaluates the run against its truth, which may have no attitudes. Figures that do not apply are
/// null. Adds a remark if the truth cannot be compared.
nlohmann::ordered_json evaluation_json(const Run& run, const std::string& chart, bool attitudes,
                                       std::vector<std::string>& remarks);

/// The first part of summary.json: name, version, mode, chart, counts, figures, pairing.
nlohmann::ordered_json run_json(const Run& run, const FrameCoverage& coverage,
                                const std::string& mode, const std::string& chart,
                                const std::vector<TrueLandmark>& true_landmarks,
                                std::vector<std::string>& remarks, bool truth_attitudes = true);

/// The array `cameras` of summary.json (docs/formats.md): extrinsics (imu_T_cam) and intrinsics of
/// the recording's cameras. The page uses them to draw the cameras.
nlohmann::ordered_json cameras_json(const Recording& recording);

}  // namespace chasles
