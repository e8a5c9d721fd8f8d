#include "scene_options.hpp"

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/lab/true_motion.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/settings_io.hpp>
#include <chasles/sim/street.hpp>

#include "options.hpp"

namespace chasles::app {
namespace {

constexpr const char* kTrajectory = "trajectory";

// Knot spacing [s]: that of the truth's poses, if it is finer than `coarsest`. Coarser knots smooth
// away motion that the real samples contain.
double knots_for(const Trajectory& truth, double coarsest) {
  constexpr double kFinest = 0.02;  // [s]
  std::vector<double> spacings;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    spacings.push_back(to_seconds(truth[i].time - truth[i - 1].time));
  }
  if (spacings.empty()) return coarsest;
  const auto median = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), median, spacings.end());  // the median ignores gaps
  return std::clamp(*median, std::min(kFinest, coarsest), coarsest);
}

// Takes samples, convention and noise densities from the recording.
void take_real_imu(const std::filesystem::path& path, InertialScene& scene) {
  const Recording recording = read_recording(path);
  if (recording.imu.empty()) {
    throw InputError(fmt::format("{}: has no IMU samples, which --real-imu needs", path.string()));
  }
  scene.imu = recording.imu;
  scene.imu_truth = recording.true_motion;
  InertialSettings& s = scene.settings;
  s.knot_interval = knots_for(scene.path, s.knot_interval);
  s.imu_convention = recording.imu_convention;
  if (!recording.imu_noise) return;
  s.accelerometer_noise_density = recording.imu_noise->accelerometer_noise_density;
  s.gyroscope_noise_density = recording.imu_noise->gyroscope_noise_density;
  s.accelerometer_random_walk = recording.imu_noise->accelerometer_random_walk;
  s.gyroscope_random_walk = recording.imu_noise->gyroscope_random_walk;
}

void take_path(const SceneChoice& choice, InertialScene& scene) {
  if (choice.name != kTrajectory) return reject_path(choice);
  if (choice.agreed_truth && !choice.real_imu) {
    throw UsageError("--agreed-truth needs --real-imu: it fuses the truth with the real samples");
  }
  if (choice.path.empty()) {
    throw UsageError(
        fmt::format("the scene {} needs --path FILE: a TUM trajectory, or a "
                    "recording that has the truth",
                    kTrajectory));
  }
  std::vector<std::string> remarks;
  StatedTruth truth = read_truth(choice.path, remarks);
  if (!truth.attitudes) {
    throw InputError(
        fmt::format("{}: has positions and no attitudes, expected poses", choice.path.string()));
  }
  scene.path = std::move(truth.poses);
  for (const std::string& remark : remarks) spdlog::warn("{}", remark);
  if (choice.real_imu) take_real_imu(choice.path, scene);
}

}  // namespace

void check_scene(const std::string& name) {
  std::vector<std::string> known;
  for (const StreetScene& scene : street_scenes()) known.push_back(scene.name);
  for (const InertialScene& scene : inertial_scenes()) known.push_back(scene.name);
  if (std::ranges::find(known, name) != known.end()) return;
  throw UsageError(fmt::format("unknown scene '{}'{} (known scenes: {})", name,
                               did_you_mean(name, known), fmt::join(known, ", ")));
}

void declare_path(CLI::App& parser, SceneChoice& choice, const std::string& group) {
  parser
      .add_option("--path", choice.path,
                  "For the scene trajectory: a TUM file, or a recording that has the truth")
      ->type_name("FILE")
      ->group(group);
  parser
      .add_flag(
          "--real-imu", choice.real_imu,
          "Use the IMU samples of the recording at --path instead of simulated ones. The knots of "
          "the motion have the spacing of the truth's poses, but at least 0.02 s")
      ->group(group);
  parser
      .add_flag(
          "--agreed-truth", choice.agreed_truth,
          "With --real-imu: move along the fusion of truth and samples. The poses of the truth "
          "alone have jitter and a tilt against the IMU")
      ->group(group);
}

void reject_path(const SceneChoice& choice) {
  if (choice.path.empty() && !choice.real_imu && !choice.agreed_truth) return;
  throw UsageError(
      fmt::format("--path, --real-imu and --agreed-truth are for the scene {}, not for {}",
                  kTrajectory, choice.name));
}

void declare_scene(CLI::App& parser, SceneChoice& choice) {
  choice.set_option = "--scene-set";
  const auto add = [&](const char* name, auto& value, const char* type, const char* meaning) {
    return parser.add_option(name, value, meaning)->type_name(type)->group("Scene");
  };
  declare_path(parser, choice, "Scene");
  add("--seed", choice.seed, "N", "Seed of landmarks and noise");
  add("--scene-config", choice.config, "FILE", "Settings of the scene from a YAML file");
  add("--scene-set", choice.sets, "KEY=VALUE", "One setting of the scene; may be repeated")
      ->allow_extra_args(false);
}

bool is_inertial_scene(const std::string& name) {
  return std::ranges::find(inertial_scenes(), name, &InertialScene::name) !=
         inertial_scenes().end();
}

InertialScene scene_from(const SceneChoice& choice) {
  InertialScene scene = inertial_scene(choice.name);
  take_path(choice, scene);
  const SettingList list = list_of(scene.settings);
  const Geometry geometry = scene.settings.geometry;
  if (!choice.config.empty()) set_from_file(list, choice.config);
  for (const std::string& assignment : choice.sets) assign(list, choice.set_option, assignment);
  if (!choice.seed.empty()) set(list, "--seed", "seed", choice.seed);
  if (scene.settings.geometry != geometry) {
    throw UsageError(
        fmt::format("the setting geometry is that of the scene: found '{}', expected '{}'",
                    name_of(scene.settings.geometry), name_of(geometry)));
  }
  validate(scene.settings);
  if (choice.agreed_truth) spdlog::info("{}", make_agree(scene));
  return scene;
}

std::uint64_t seed_from(const SceneChoice& choice) {
  InertialSettings settings;
  if (!choice.seed.empty()) set(list_of(settings), "--seed", "seed", choice.seed);
  return settings.seed;
}

std::string inertial_scenes_help() {
  std::string text;
  for (const InertialScene& scene : inertial_scenes()) {
    text += fmt::format("  {:<14} {}\n", scene.name, scene.doc);
  }
  return text;
}

std::string inertial_settings_help() {
  InertialSettings defaults;
  // A line for each lens model.
  std::string lenses = "\nLens models, with the coefficients distortion_1, distortion_2, ...:\n  ";
  for (const char c : lens_model_coefficients()) {
    if (c != ' ' || !lenses.ends_with("),")) {
      lenses += c;
    } else {
      lenses.back() = '\n';
      lenses += "  ";
    }
  }
  return help_text(list_of(defaults)) + lenses + "\n";
}

nlohmann::ordered_json settings_json(const InertialSettings& settings) {
  InertialSettings copy = settings;
  return to_json(list_of(copy));
}

}  // namespace chasles::app
