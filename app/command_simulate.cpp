#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/street.hpp>

#include "output_folder.hpp"
#include "scene_options.hpp"
#include "settings_io.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

struct SimulateOptions {
  SceneChoice scene;
  std::filesystem::path output;
  std::uint64_t run = 0;
  bool json = false, quiet = false;
};

SettingList setting_list(StreetSettings& settings) {
  SettingCollector collector;
  for_each_field(settings, collector);
  return collector.settings;
}

std::string scenes_help() {
  std::string text = "Scenes with velocities and a stereo pair:\n";
  for (const StreetScene& scene : street_scenes()) {
    text += fmt::format("  {:<14} {}\n", scene.name, scene.doc);
  }
  text += "\nScenes with an IMU and single cameras:\n" + inertial_scenes_help();
  StreetSettings defaults;
  return text +
         "\nSettings of the first, for --set and --config (defaults are those of `street`):\n" +
         help_text(setting_list(defaults)) +
         "\nSettings of the second (defaults are those of `hallway`):\n" + inertial_settings_help();
}

StreetSettings street_settings_from(const SceneChoice& choice) {
  if (!choice.path.empty() || choice.real_imu) {
    throw UsageError(
        fmt::format("--path and --real-imu are for the scene trajectory, not for {}", choice.name));
  }
  StreetSettings settings = street_scene(choice.name);
  const SettingList list = setting_list(settings);
  if (!choice.config.empty()) set_from_file(list, choice.config);
  for (const std::string& assignment : choice.sets) set(list, assignment);
  if (!choice.seed.empty()) set(list, "--seed", "seed", choice.seed);
  validate(settings);
  return settings;
}

// A name that nobody knows is told with all that are known.
void check_known(const std::string& name) {
  std::vector<std::string> known;
  for (const StreetScene& scene : street_scenes()) known.push_back(scene.name);
  for (const InertialScene& scene : inertial_scenes()) known.push_back(scene.name);
  if (std::ranges::find(known, name) != known.end()) return;
  throw UsageError(fmt::format("unknown scene '{}'{} (known scenes: {})", name,
                               did_you_mean(name, known), fmt::join(known, ", ")));
}

double recorded_seconds(const Recording& recording) {
  if (recording.frames.empty()) return 0;
  return to_seconds(recording.frames.back().time - recording.frames.front().time);
}

Json description(const Recording& recording, const Json& settings) {
  std::size_t observations = 0;
  for (const FeatureFrame& frame : recording.frames) {
    observations += frame.observations.size() + frame.pixels.size();
  }
  return {{"name", recording.name},
          {"frames", recording.frames.size()},
          {"velocities", recording.velocities.size()},
          {"imu_samples", recording.imu.size()},
          {"observations", observations},
          {"landmarks", recording.true_landmarks.size()},
          {"recorded_seconds", recorded_seconds(recording)},
          {"path_m", path_length(recording.truth)},
          {"settings", settings}};
}

void print(const SimulateOptions& o, const Recording& recording, const Json& json) {
  if (o.json) {
    fmt::print("{}\n", json.dump(2));
  } else if (!o.quiet) {
    fmt::print(
        "{}: {} frames in {:.1f} s, {:.0f} m {}, {} landmarks, {} observations\n"
        "recording: {}\n",
        recording.name, recording.frames.size(), recorded_seconds(recording),
        json["path_m"].get<double>(), recording.imu.empty() ? "driven" : "long",
        recording.true_landmarks.size(), json["observations"].get<std::size_t>(),
        o.output.string());
  }
}

int deliver(const SimulateOptions& o, const Recording& recording, const Json& settings) {
  write_folder_recording(recording, o.output);
  print(o, recording, description(recording, settings));
  return 0;
}

int simulate(const SimulateOptions& o) {
  check_known(o.scene.name);
  if (is_inertial_scene(o.scene.name)) {
    const InertialScene scene = scene_from(o.scene);
    prepare_output(o.output);
    return deliver(o, simulate_inertial(scene, o.run), settings_json(scene.settings));
  }
  if (o.run != 0) {
    throw UsageError(
        fmt::format("--run is for scenes with an IMU; for {} there is --seed", o.scene.name));
  }
  StreetSettings settings = street_settings_from(o.scene);
  prepare_output(o.output);
  return deliver(o, simulate_street(settings), to_json(setting_list(settings)));
}

}  // namespace

Action declare_simulate(CLI::App& parser) {
  const auto o = std::make_shared<SimulateOptions>();
  SceneChoice& scene = o->scene;
  parser.add_option("SCENE", scene.name, "Name of the scene")->required()->type_name("");
  parser.add_option("-o,--output", o->output, "Folder for the recording")
      ->required()
      ->type_name("RECORDING");
  parser.add_option("--config", scene.config, "Settings from a YAML file, `key: value` a line")
      ->type_name("FILE");
  parser.add_option("--set", scene.sets, "One setting; may be repeated, the last one counts")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  parser.add_option("--seed", scene.seed, "Chooses all random numbers")->type_name("N");
  parser.add_option("--run", o->run, "Which run of the noise, in scenes with an IMU")
      ->type_name("K");
  parser
      .add_option("--path", scene.path,
                  "For the scene trajectory: a TUM file, or a recording that has the truth")
      ->type_name("FILE");
  parser.add_flag("--real-imu", scene.real_imu,
                  "The IMU samples of the recording at --path instead of simulated ones");
  parser.add_flag("--json", o->json, "Print what was simulated as JSON");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  parser.footer(scenes_help());
  return [o] { return simulate(*o); };
}

}  // namespace chasles::app
