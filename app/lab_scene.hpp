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

/// A scene with the filters that are studied in it.
struct LabScene {
  std::vector<FilterVariant> filters;
  nlohmann::ordered_json plan;  ///< plan.json
  /// As run_monte_carlo().
  std::function<void(const std::vector<std::uint64_t>& runs, int workers, const RecordsDone& done)>
      work;
};

/// The scene of any kind. Throws as scene_from() and filters_from().
LabScene lab_scene(const SceneChoice& scene, const FilterOptions& filters);

/// Scenes, settings of filters and settings of scenes, for --help.
std::string lab_help();

}  // namespace chasles::app
