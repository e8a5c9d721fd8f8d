#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/data/readers.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/sim/street.hpp>

#include "output_folder.hpp"
#include "settings_io.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

struct SimulateOptions {
  std::string scene;
  std::filesystem::path output;
  std::string config, seed;
  std::vector<std::string> sets;
  bool json = false, quiet = false;
};

SettingList setting_list(StreetSettings& settings) {
  SettingCollector collector;
  for_each_field(settings, collector);
  return collector.settings;
}

std::string scenes_help() {
  std::string text = "Scenes:\n";
  for (const StreetScene& scene : street_scenes()) {
    text += fmt::format("  {:<14} {}\n", scene.name, scene.doc);
  }
  StreetSettings defaults;
  return text + "\nSettings, for --set and --config (defaults are those of `street`):\n" +
         help_text(setting_list(defaults));
}

StreetSettings settings_from(const SimulateOptions& o) {
  StreetSettings settings = street_scene(o.scene);
  const SettingList list = setting_list(settings);
  if (!o.config.empty()) set_from_file(list, o.config);
  for (const std::string& assignment : o.sets) set(list, assignment);
  if (!o.seed.empty()) set(list, "--seed", "seed", o.seed);
  validate(settings);
  return settings;
}

nlohmann::ordered_json description(const Recording& recording, StreetSettings settings) {
  std::size_t observations = 0;
  for (const FeatureFrame& frame : recording.frames) observations += frame.observations.size();
  const double seconds =
      recording.frames.empty()
          ? 0
          : to_seconds(recording.frames.back().time - recording.frames.front().time);
  return {{"name", recording.name},
          {"frames", recording.frames.size()},
          {"velocities", recording.velocities.size()},
          {"observations", observations},
          {"landmarks", recording.true_landmarks.size()},
          {"recorded_seconds", seconds},
          {"path_m", path_length(recording.truth)},
          {"settings", to_json(setting_list(settings))}};
}

int simulate(const SimulateOptions& o) {
  const StreetSettings settings = settings_from(o);
  prepare_output(o.output);
  const Recording recording = simulate_street(settings);
  write_folder_recording(recording, o.output);
  const nlohmann::ordered_json json = description(recording, settings);
  if (o.json) {
    fmt::print("{}\n", json.dump(2));
  } else if (!o.quiet) {
    fmt::print(
        "{}: {} frames in {:.1f} s, {:.0f} m driven, {} landmarks, {} observations\n"
        "recording: {}\n",
        recording.name, recording.frames.size(), json["recorded_seconds"].get<double>(),
        json["path_m"].get<double>(), recording.true_landmarks.size(),
        json["observations"].get<std::size_t>(), o.output.string());
  }
  return 0;
}

}  // namespace

Action declare_simulate(CLI::App& parser) {
  const auto o = std::make_shared<SimulateOptions>();
  parser.add_option("SCENE", o->scene, "Name of the scene")->required()->type_name("");
  parser.add_option("-o,--output", o->output, "Folder for the recording")
      ->required()
      ->type_name("RECORDING");
  parser.add_option("--config", o->config, "Settings from a YAML file, `key: value` a line")
      ->type_name("FILE");
  parser.add_option("--set", o->sets, "One setting; may be repeated, the last one counts")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  parser.add_option("--seed", o->seed, "Chooses all random numbers")->type_name("N");
  parser.add_flag("--json", o->json, "Print what was simulated as JSON");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  parser.footer(scenes_help());
  return [o] { return simulate(*o); };
}

}  // namespace chasles::app
