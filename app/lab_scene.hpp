#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/lab/monte_carlo.hpp>

#include "filter_options.hpp"
#include "scene_options.hpp"

namespace chasles::app {

/// A scene with the filters of a study.
struct LabScene {
  std::vector<FilterVariant> filters;
  nlohmann::ordered_json plan;  ///< content of plan.json
  /// As run_monte_carlo().
  std::function<void(const std::vector<std::uint64_t>& runs, int workers, const RecordsDone& done)>
      work;
};

/// Prepares a scene of any kind. Throws as scene_from() and filters_from().
LabScene lab_scene(const SceneChoice& scene, const FilterOptions& filters);

/// "hallway, turntable, ..., loops": all scenes of a study.
std::string lab_scene_names();

/// Help text: scenes, settings of filters and settings of scenes.
std::string lab_help();

}  // namespace chasles::app
