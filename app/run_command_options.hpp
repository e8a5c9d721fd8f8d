#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "live_view.hpp"
#include "run_input.hpp"
#include "thresholds.hpp"
#include "velocity_settings_io.hpp"

namespace CLI {
class App;
}

namespace chasles::app {

/// The options of the command `run`.
struct RunCommandOptions {
  RunInput input;
  SettingSources settings;
  std::filesystem::path trajectory, output, full_covariance, map, save_map;
  bool extend = false;
  std::string begin = "auto", estimator = "filter";
  int threads = 3;
  bool realtime = false;
  std::optional<double> realtime_speed;
  bool json = false, quiet = false;
  LiveOptions live;
  std::optional<int> keep_images;
  /// Called after each frame, with the number of all: a progress bar of another program.
  std::function<void(std::size_t frames, std::size_t of)> on_frames = {};
  std::vector<Threshold> thresholds = run_thresholds();
};

/// Adds them to the parser of the command, with the help on settings. `options` must outlive it.
void declare_run_options(CLI::App& parser, RunCommandOptions& options);

}  // namespace chasles::app
