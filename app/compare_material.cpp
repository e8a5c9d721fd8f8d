#include "compare_material.hpp"

#include <filesystem>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/lab/loops.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/sim/inertial_sim.hpp>

#include "lab_scene.hpp"
#include "loops_options.hpp"

namespace chasles::app {
namespace {

CompareMaterial loops_material(const SceneChoice& choice, const FilterOptions& options,
                               std::uint64_t run) {
  const LoopsSettings settings = loops_from(choice);
  CompareMaterial material{
      .name = settings.name, .seed = settings.seed, .scene = settings_json(settings)};
  material.truth = loops_truth(settings);
  material.frames = material.truth.size();
  material.landmarks = loops_landmarks(settings);
  material.filters = loops_filters_from(options);
  material.run = [settings, run](const FilterVariant& filter) {
    return run_loops(settings, filter, run, KeepMap::kYes);
  };
  material.settings = [](const FilterVariant& f) { return loops_settings_json(f.settings); };
  return material;
}

CompareMaterial of_recording(Recording recording, std::vector<FilterVariant> filters,
                             std::uint64_t seed, std::uint64_t run) {
  CompareMaterial material{.name = recording.name, .seed = seed};
  material.remarks = recording.remarks;
  material.frames = recording.frames.size();
  material.truth = recording.truth;
  material.landmarks = recording.true_landmarks;
  material.filters = std::move(filters);
  const auto kept = std::make_shared<const Recording>(std::move(recording));
  material.run = [kept, seed, run](const FilterVariant& filter) {
    Trial trial =
        run_trial(filter, *kept, draw_start(*kept, filter.settings, seed, run), KeepMap::kYes);
    trial.run = run;
    return trial;
  };
  material.settings = [](const FilterVariant& f) { return settings_json(f); };
  return material;
}

// A path that exists is a recording, any other name a misspelt scene.
void check_recording(const SceneChoice& choice) {
  std::error_code ignored;
  if (!std::filesystem::exists(choice.name, ignored)) {
    throw UsageError(
        fmt::format("'{}' is neither a scene nor a recording: expected one of {}, or a recording "
                    "with an IMU, cameras and the truth",
                    choice.name, lab_scene_names()));
  }
  if (!choice.sets.empty() || !choice.config.empty() || !choice.path.empty()) {
    throw UsageError(
        fmt::format("--scene-set, --scene-config and --path are for scenes, not for "
                    "the recording {}",
                    choice.name));
  }
}

}  // namespace

CompareMaterial compare_material(const SceneChoice& choice, const FilterOptions& options,
                                 std::uint64_t run) {
  if (is_loops(choice.name)) return loops_material(choice, options, run);
  // Before the slow reading of the recording.
  std::vector<FilterVariant> filters = filters_from(options);
  if (is_inertial_scene(choice.name)) {
    const InertialScene scene = scene_from(choice);
    CompareMaterial material =
        of_recording(simulate_inertial(scene, run), std::move(filters), scene.settings.seed, run);
    material.scene = settings_json(scene.settings);
    return material;
  }
  check_recording(choice);
  return of_recording(read_recording(choice.name), std::move(filters), seed_from(choice), run);
}

}  // namespace chasles::app
