#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/run_settings.hpp>

#include "run_settings.hpp"

namespace chasles::app {

/// As settings_from() of run_settings.hpp: keys of the filter as they are, those of the start
/// behind "start.", those of the front end behind "frontend.", of batch estimation behind "batch.".
InertialRunSettings inertial_run_settings_from(const SettingSources& sources);

/// All of them by name.
nlohmann::ordered_json settings_json(const InertialRunSettings& settings);

/// The settings of start, front end and batch estimation as --help lists them.
std::string inertial_run_settings_help();

/// Every setting of an inertial filter.
SettingList setting_list(InertialSlamSettings& settings);
/// Every setting of batch estimation, behind "batch.".
SettingList setting_list(BatchSettings& settings);

/// All settings of an inertial filter by name.
nlohmann::ordered_json settings_json(const InertialSlamSettings& settings);
/// The same as --help lists them.
std::string filter_settings_help();

}  // namespace chasles::app
