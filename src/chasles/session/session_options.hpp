#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <chasles/session/recording_input.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles {

/// What a run of a recording is asked for, by a command line or another program (run_job.hpp).
/// Messages name the options of `chasles run`.
struct SessionOptions {
  RecordingInput input;
  SettingSources settings;
  std::filesystem::path trajectory, full_covariance, map, save_map;
  bool extend = false;  ///< saves into `map`
  std::string begin = "auto", estimator = "filter";
  bool as_recorded = false;  ///< without examine_tracks()
  int threads = 3;
  bool realtime = false;
  std::optional<double> realtime_speed;
  bool quiet = false;              ///< no progress bar
  std::optional<int> keep_images;  ///< as for ImageKeeper
};

}  // namespace chasles
