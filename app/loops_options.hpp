#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/loops.hpp>

#include "filter_options.hpp"
#include "scene_options.hpp"

namespace chasles::app {

// The scene `loops` has odometry and points instead of an IMU and cameras: settings and filters of
// its own.

/// Whether that is the name of the scene.
bool is_loops(const std::string& name);

/// Throws UsageError for a setting that does not fit, and as refuse_path().
LoopsSettings loops_from(const SceneChoice& choice);

/// The files and the charts asked for, all four charts where nothing is. Throws UsageError for what
/// is not known or there twice, and for options that mean nothing without an IMU and cameras.
std::vector<FilterVariant> loops_filters_from(const FilterOptions& options);

/// The scene in a line and its settings, for --help.
std::string loops_scene_help();
std::string loops_settings_help();

/// All settings by name: of the scene, and of a filter as far as they count in it.
nlohmann::ordered_json settings_json(const LoopsSettings& settings);
nlohmann::ordered_json loops_settings_json(const InertialSlamSettings& settings);

}  // namespace chasles::app
