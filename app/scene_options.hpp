#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/sim/inertial_settings.hpp>

#include "settings_io.hpp"

namespace CLI {
class App;
}

namespace chasles::app {

/// A scene with an IMU as the command line describes it.
struct SceneChoice {
  std::string name;
  std::filesystem::path path;  ///< for the scene `trajectory`: a TUM file or a recording with truth
  bool real_imu = false;       ///< the samples of the recording at `path` instead of simulated ones
  bool agreed_truth = false;   ///< with them: the motion that they and the truth agree on
  std::string config, seed;
  std::vector<std::string> sets;     ///< key=value
  std::string set_option = "--set";  ///< for messages
};

/// --path, --real-imu and --agreed-truth, in that group of --help.
void declare_path(CLI::App& parser, SceneChoice& choice, const std::string& group);
/// Throws UsageError where one of them is given: the choice's scene is not `trajectory`.
void refuse_path(const SceneChoice& choice);

/// Declares the options of a scene beside its name: those of its path, --seed, and the settings as
/// --scene-set and --scene-config.
void declare_scene(CLI::App& parser, SceneChoice& choice);

/// As set(), but with the option's own name in messages.
void assign(const SettingList& list, const std::string& option, const std::string& assignment);

/// Whether that is the name of a scene with an IMU.
bool is_inertial_scene(const std::string& name);

/// Throws UsageError for a name, a setting or a path that does not fit, InputError for a file.
InertialScene scene_from(const SceneChoice& choice);

/// The seed alone, for what is no scene; 1 where none is given.
std::uint64_t seed_from(const SceneChoice& choice);

/// The scenes, a line each, and their settings, for --help.
std::string inertial_scenes_help();
std::string inertial_settings_help();

/// All settings by name.
nlohmann::ordered_json settings_json(const InertialSettings& settings);

}  // namespace chasles::app
