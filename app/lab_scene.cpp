#include "lab_scene.hpp"

#include <chasles/lab/loops.hpp>
#include <chasles/session/inertial_settings_io.hpp>

#include "loops_options.hpp"
#include "trial_log.hpp"

namespace chasles::app {
namespace {

LabScene loops_scene(const SceneChoice& choice, const FilterOptions& options) {
  const LoopsSettings settings = loops_from(choice);
  LabScene scene;
  scene.filters = loops_filters_from(options);
  scene.plan = plan_json(settings, scene.filters);
  const auto records = [settings, filters = scene.filters](std::uint64_t run) {
    std::vector<TrialRecord> result;
    for (const FilterVariant& filter : filters) {
      result.push_back(record_of(run_loops(settings, filter, run)));
    }
    return result;
  };
  scene.work = [records](const std::vector<std::uint64_t>& runs, int workers,
                         const RecordsDone& done) {
    run_monte_carlo(runs, workers, records, done);
  };
  return scene;
}

}  // namespace

LabScene lab_scene(const SceneChoice& choice, const FilterOptions& options) {
  if (is_loops(choice.name)) return loops_scene(choice, options);
  MonteCarloPlan plan{.scene = scene_from(choice), .filters = filters_from(options), .runs = {}};
  LabScene scene;
  scene.filters = plan.filters;
  scene.plan = plan_json(plan.scene, plan.filters);
  scene.work = [plan](const std::vector<std::uint64_t>& runs, int workers,
                      const RecordsDone& done) {
    MonteCarloPlan part = plan;
    part.runs = runs;
    run_monte_carlo(part, workers, done);
  };
  return scene;
}

std::string lab_scene_names() {
  std::string names;
  for (const InertialScene& scene : inertial_scenes()) names += scene.name + ", ";
  return names + "loops";
}

std::string lab_help() {
  return "Scenes:\n" + inertial_scenes_help() + loops_scene_help() + "\n" + filter_settings_help() +
         "\nThe scene loops accepts only the settings chart and first_estimates.\n"
         "\nSettings of a scene, for --scene-set (defaults are those of `hallway`):\n" +
         inertial_settings_help() + "\nSettings of the scene loops:\n" + loops_settings_help();
}

}  // namespace chasles::app
