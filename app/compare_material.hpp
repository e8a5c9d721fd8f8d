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

/// What `chasles compare` gives to every filter.
struct CompareMaterial {
  std::string name;
  std::uint64_t seed = 1;
  nlohmann::ordered_json scene = nullptr;  ///< the scene's settings; null: a recording
  std::vector<std::string> remarks = {};
  std::size_t frames = 0;
  Trajectory truth = {};                     ///< world_T_imu
  std::vector<TrueLandmark> landmarks = {};  ///< empty where unknown
  std::vector<FilterVariant> filters = {};
  std::function<Trial(const FilterVariant&)> run = {};
  /// The settings of a filter that count.
  std::function<nlohmann::ordered_json(const FilterVariant&)> settings = {};
};

/// A scene of any kind, or a recording with an IMU, cameras and the truth, and the filters asked
/// for. `run` is that of the noise, or of the errors of the start. Throws UsageError for what is
/// neither, or does not fit, InputError for a file.
CompareMaterial compare_material(const SceneChoice& scene, const FilterOptions& filters,
                                 std::uint64_t run);

}  // namespace chasles::app
