#pragma once

#include <string>
#include <vector>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/reader_settings.hpp>

#include "settings_io.hpp"

namespace chasles::app {

/// The settings of a stereo-velocity run.
SettingList setting_list(VelocitySlamSettings& settings);
SettingList setting_list(ReaderSettings& settings);

/// Sources of the settings. Later ones override earlier ones: the program's defaults, the file of
/// --config, each --set in turn, the options that name a setting (--chart, --mode).
struct SettingSources {
  std::string config;                ///< empty: none
  std::vector<std::string> sets;     ///< key=value
  std::string set_option = "--set";  ///< where they come from, in messages
  std::string chart, mode;           ///< empty: not given
  EstimatorChoice estimator = {};
};

/// All settings of the command `run` for such a recording.
struct VelocityCommandSettings : VelocityRunSettings {
  ReaderSettings reader = {};
};

/// Reads them from their sources. Keys of batch estimation have the prefix "batch.", those of the
/// reader "reader.". Throws UsageError or InputError as set(), set_from_file() and validate() do.
VelocityCommandSettings velocity_run_settings_from(const SettingSources& sources);

}  // namespace chasles::app
