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

/// Selection of a scene with an IMU on the command line.
struct SceneChoice {
  std::string name;
  std::filesystem::path path;  ///< for the scene `trajectory`: a TUM file or a recording with truth
  bool real_imu = false;       ///< IMU samples of the recording at `path`, none simulated
  bool agreed_truth = false;   ///< with real_imu: motion fused from truth and samples
  std::string config, seed;
  std::vector<std::string> sets;     ///< key=value
  std::string set_option = "--set";  ///< name of the option in messages
};

/// Declares --path, --real-imu and --agreed-truth in this group of --help.
void declare_path(CLI::App& parser, SceneChoice& choice, const std::string& group);
/// Throws UsageError if one of these options is given. For scenes other than `trajectory`.
void reject_path(const SceneChoice& choice);

/// Declares the options of a scene: those of declare_path(), --seed, --scene-set, --scene-config.
void declare_scene(CLI::App& parser, SceneChoice& choice);

/// As set(), with the name of `option` in messages.
void assign(const SettingList& list, const std::string& option, const std::string& assignment);

/// Throws UsageError with the known scenes, those with body velocities among them, for another
/// name.
void check_scene(const std::string& name);

/// Whether `name` is that of a scene with an IMU.
bool is_inertial_scene(const std::string& name);

/// The chosen scene. Throws UsageError for an invalid name, setting or path, InputError for a file
/// that cannot be read.
InertialScene scene_from(const SceneChoice& choice);

/// The seed, for a recording instead of a scene; 1 if none is given.
std::uint64_t seed_from(const SceneChoice& choice);

/// Help text: the scenes, one line each, and their settings.
std::string inertial_scenes_help();
std::string inertial_settings_help();

/// All settings by name.
nlohmann::ordered_json settings_json(const InertialSettings& settings);

}  // namespace chasles::app
