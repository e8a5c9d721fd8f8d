#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/frontend/frontend_settings.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

#include "run_settings.hpp"

namespace chasles::app {

/// All that can be set about a run with an IMU: keys of the filter as they are, those of the start
/// behind "start.", those of the front end behind "frontend.", of batch estimation behind "batch.".
struct InertialRunSettings {
  InertialSlamSettings filter;
  InitialiserSettings start;
  FrontendSettings frontend;
  BatchSettings batch;
};

/// As settings_from() of run_settings.hpp.
InertialRunSettings inertial_run_settings_from(const SettingSources& sources);

/// All of them by name.
nlohmann::ordered_json settings_json(const InertialRunSettings& settings);

/// The settings of start, front end and batch estimation as --help lists them.
std::string inertial_run_settings_help();

}  // namespace chasles::app
