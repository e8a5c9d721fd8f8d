#include <algorithm>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/write_euroc.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/output_folder.hpp>
#include <chasles/session/progress.hpp>
#include <chasles/session/settings_io.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/street.hpp>

#include "options.hpp"
#include "print.hpp"
#include "scene_options.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

struct SimulateOptions {
  SceneChoice scene;
  std::filesystem::path output, cameras;
  std::uint64_t run = 0;
  int threads = 0;  // 0: one per core
  bool images = false;
  bool json = false, quiet = false;
};

std::string scenes_help() {
  std::string text = "Scenes with velocities and a stereo pair:\n";
  for (const StreetScene& scene : street_scenes()) {
    text += fmt::format("  {:<14} {}\n", scene.name, scene.doc);
  }
  text += "\nScenes with an IMU and single cameras:\n" + inertial_scenes_help();
  StreetSettings defaults;
  return text +
         "\nSettings of the first, for --set and --config (defaults are those of `street`):\n" +
         help_text(list_of(defaults)) +
         "\nSettings of the second (defaults are those of `hallway`):\n" + inertial_settings_help();
}

StreetSettings street_settings_from(const SceneChoice& choice) {
  reject_path(choice);
  StreetSettings settings = street_scene(choice.name);
  const SettingList list = list_of(settings);
  if (!choice.config.empty()) set_from_file(list, choice.config);
  for (const std::string& assignment : choice.sets) set(list, assignment);
  if (!choice.seed.empty()) set(list, "--seed", "seed", choice.seed);
  validate(settings);
  return settings;
}

double recorded_seconds(const Recording& recording) {
  if (recording.frames.empty()) return 0;
  return to_seconds(recording.frames.back().time - recording.frames.front().time);
}

// Replaces the cameras of the settings by those of a recording. The setting `cameras` is their
// number.
void take_cameras(const std::filesystem::path& path, InertialScene& scene) {
  scene.cameras = read_recording(path).cameras;
  const auto wanted = static_cast<std::size_t>(scene.settings.cameras);
  if (scene.cameras.size() < wanted) {
    throw UsageError(
        fmt::format("--cameras {}: has {} cameras; expected {}, as the setting cameras",
                    path.string(), scene.cameras.size(), wanted));
  }
  scene.cameras.resize(wanted);
}

Json images_description(const Recording& recording, std::size_t frames, const Json& settings) {
  const ImageSource& images = *recording.images;
  return {{"name", recording.name},
          {"frames", frames},
          {"cameras", recording.cameras.size()},
          {"imu_samples", recording.imu.size()},
          {"recorded_seconds", to_seconds(images.time(frames - 1) - images.time(0))},
          {"path_m", path_length(recording.truth)},
          {"settings", settings}};
}

std::string images_text(std::size_t cameras) {
  if (cameras == 1) return "one image";
  return cameras == 2 ? "two images" : fmt::format("{} images", cameras);
}

// Ends early if interrupted.
std::size_t write_images(const SimulateOptions& o, const Recording& recording,
                         const Interrupt& interrupt) {
  const ImageSource& images = *recording.images;
  Progress progress(images.size(), o.quiet || o.json);
  const auto done = [&](std::size_t frames) {
    progress.show(frames, to_seconds(images.time(frames - 1) - images.time(0)));
    return !interrupt.requested();
  };
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  return write_euroc(recording, o.output, done, o.threads > 0 ? o.threads : cores);
}

int simulate_images(const SimulateOptions& o, const InertialScene& scene) {
  make_folder(o.output);
  const OutputLock lock(o.output);
  prepare_euroc_folder(o.output);
  const Recording recording = render_inertial(scene, o.run);
  const Interrupt interrupt(Interrupt::kPatienceOfRun);
  const std::size_t frames = write_images(o, recording, interrupt);
  const Json json = images_description(recording, frames, settings_json(scene.settings));
  if (o.json) {
    app::print("{}\n", json_text(json, 2));
  } else if (!o.quiet) {
    app::print("{}: {} frames of {} in {:.1f} s, {:.0f} m long\nrecording: {}\n", recording.name,
               frames, images_text(recording.cameras.size()),
               json["recorded_seconds"].get<double>(), json["path_m"].get<double>(),
               o.output.string());
  }
  return interrupt.requested() ? Interrupt::kExitCode : 0;
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
    app::print("{}\n", json_text(json, 2));
  } else if (!o.quiet) {
    app::print(
        "{}: {} frames in {:.1f} s, {:.0f} m {}, {} landmarks, {} observations\n"
        "recording: {}\n",
        recording.name, recording.frames.size(), recorded_seconds(recording),
        json["path_m"].get<double>(), recording.imu.empty() ? "driven" : "long",
        recording.true_landmarks.size(), json["observations"].get<std::size_t>(),
        o.output.string());
  }
}

int deliver(const SimulateOptions& o, const Recording& recording, const Json& settings) {
  const OutputLock lock(o.output);
  write_folder_recording(recording, o.output);
  print(o, recording, description(recording, settings));
  return 0;
}

int simulate(const SimulateOptions& o) {
  if (o.quiet) spdlog::set_level(spdlog::level::err);
  check_scene(o.scene.name);
  reject_output_into(o.output, o.cameras);
  reject_output_into(o.output, o.scene.path);
  if (is_inertial_scene(o.scene.name)) {
    InertialScene scene = scene_from(o.scene);
    if (!o.cameras.empty()) take_cameras(o.cameras, scene);
    if (o.images) return simulate_images(o, scene);
    prepare_output(o.output);
    return deliver(o, simulate_inertial(scene, o.run), settings_json(scene.settings));
  }
  if (o.images || !o.cameras.empty()) {
    throw UsageError(
        fmt::format("--images and --cameras are for scenes with an IMU, not for {}", o.scene.name));
  }
  if (o.run != 0) {
    throw UsageError(
        fmt::format("--run is for scenes with an IMU; for {} there is --seed", o.scene.name));
  }
  StreetSettings settings = street_settings_from(o.scene);
  prepare_output(o.output);
  return deliver(o, simulate_street(settings), to_json(list_of(settings)));
}

}  // namespace

Action declare_simulate(CLI::App& parser) {
  const auto o = std::make_shared<SimulateOptions>();
  SceneChoice& scene = o->scene;
  parser.add_option("SCENE", scene.name, "Name of the scene")->required()->type_name("");
  parser.add_option("-o,--output", o->output, "Folder for the recording")
      ->required()
      ->check(require_path)
      ->type_name("RECORDING");
  parser.add_option("--config", scene.config, "Settings from a YAML file, `key: value` a line")
      ->type_name("FILE");
  parser.add_option("--set", scene.sets, "One setting; may be repeated, the last one counts")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  parser.add_option("--seed", scene.seed, "Seed of all random numbers")->type_name("N");
  parser.add_option("--run", o->run, "Number of the noise realisation, in scenes with an IMU")
      ->type_name("K");
  declare_path(parser, scene, "Options");
  parser.add_flag(
      "--images", o->images,
      "Render images instead of tracks, and write an EuRoC folder (scenes with an IMU)");
  parser
      .add_option("--cameras", o->cameras, "Recording whose cameras replace those of the settings")
      ->type_name("RECORDING");
  parser
      .add_option("--threads", o->threads,
                  "Images rendered in parallel (default: one per core); the bytes are the same")
      ->type_name("N")
      ->check(CLI::Range(1, 256));
  parser.add_flag("--json", o->json, "Print the figures of the recording as JSON");
  parser.add_flag("--quiet", o->quiet, "Print nothing but errors");
  parser.footer(scenes_help());
  return [o] { return simulate(*o); };
}

}  // namespace chasles::app
