#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles {

/// As velocity_run_settings_from() of velocity_settings_io.hpp. Keys of the filter have no prefix;
/// the others have "start.", "frontend." or "batch.".
InertialRunSettings inertial_run_settings_from(const SettingSources& sources);

/// All settings of a visual-inertial run by name.
nlohmann::ordered_json settings_json(const InertialRunSettings& settings);

/// The settings of a run, from its summary.json: those that it states, and else the defaults. Not
/// the estimator. Throws InputError for a value that the setting does not have.
InertialRunSettings inertial_run_settings_of(std::string_view summary);

/// Help text of the settings of initialisation, front end and batch estimation.
std::string inertial_run_settings_help();
/// Those of the front end alone.
std::string frontend_settings_help();

/// Every setting of a visual-inertial filter.
SettingList setting_list(InertialSlamSettings& settings);
/// Every setting of batch estimation, with the prefix "batch.".
SettingList setting_list(BatchSettings& settings);

/// All settings of a visual-inertial filter by name.
nlohmann::ordered_json settings_json(const InertialSlamSettings& settings);
/// Help text of the settings of a visual-inertial filter.
std::string filter_settings_help();

}  // namespace chasles
