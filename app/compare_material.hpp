#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/lab/trial.hpp>

#include "filter_options.hpp"
#include "scene_options.hpp"

namespace chasles::app {

/// The input of `chasles compare`, common to all filters.
struct CompareMaterial {
  std::string name;
  std::uint64_t seed = 1;
  nlohmann::ordered_json scene = nullptr;  ///< settings of the scene; null for a recording
  std::vector<std::string> remarks = {};
  std::size_t frames = 0;
  Trajectory truth = {};                     ///< world_T_imu
  std::vector<TrueLandmark> landmarks = {};  ///< empty if unknown
  std::vector<FilterVariant> filters = {};
  std::function<Trial(const FilterVariant&)> run = {};
  /// The settings of a filter that affect the result.
  std::function<nlohmann::ordered_json(const FilterVariant&)> settings = {};
};

/// Prepares a scene of any kind, or a recording with an IMU, cameras and a truth, with the
/// requested filters. `run` numbers the realisation of the noise, or of the initial errors. Throws
/// UsageError for a name that is neither a scene nor a recording and for options that do not fit
/// it, InputError for a file that cannot be read.
CompareMaterial compare_material(const SceneChoice& scene, const FilterOptions& filters,
                                 std::uint64_t run);

}  // namespace chasles::app
