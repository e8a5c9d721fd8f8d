#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/loops.hpp>

#include "filter_options.hpp"
#include "scene_options.hpp"

namespace chasles::app {

// The scene `loops` has odometry and points instead of an IMU and cameras. It has settings and
// filters of its own.

/// Whether `name` is that of the scene `loops`.
bool is_loops(const std::string& name);

/// The settings of the scene. Throws UsageError for an invalid setting, and as reject_path().
LoopsSettings loops_from(const SceneChoice& choice);

/// A filter for each requested file and chart; without any, one for each of the four charts. Throws
/// UsageError for an unknown or repeated name, and for options that need an IMU or cameras.
std::vector<FilterVariant> loops_filters_from(const FilterOptions& options);

/// Help text: the scene in one line, and its settings.
std::string loops_scene_help();
std::string loops_settings_help();

/// All settings by name: those of the scene, and those of a filter that affect it.
nlohmann::ordered_json settings_json(const LoopsSettings& settings);
nlohmann::ordered_json loops_settings_json(const InertialSlamSettings& settings);

}  // namespace chasles::app
