#pragma once

#include <filesystem>
#include <string>

#include <chasles/data/recording.hpp>
#include <chasles/pipeline/estimator.hpp>

#include "run_command_options.hpp"

namespace chasles::app {

/// Where the run's map is saved; empty: nowhere. Throws UsageError for options that exclude each
/// other.
std::filesystem::path map_target(const RunCommandOptions& options);

/// Throws UsageError if a map could not be saved there. Touches nothing.
void check_map_output(const std::filesystem::path& file);

/// Saves the map of a run where that is wanted. Where there is none to save, returns the reason.
std::string save_map(const RunCommandOptions& options, const Recording& recording,
                     const Estimator& estimator);

}  // namespace chasles::app
