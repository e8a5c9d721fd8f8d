#pragma once

#include <filesystem>
#include <string>

#include <chasles/recording/recording.hpp>

#include "run_command_options.hpp"
#include "run_job.hpp"

namespace chasles::app {

/// Where the run's map is saved; empty: nowhere. Throws UsageError for options that exclude each
/// other.
std::filesystem::path map_target(const RunCommandOptions& options);

/// Throws UsageError if a map could not be saved there. Touches nothing.
void check_map_output(const std::filesystem::path& file);

/// Whether both are names of one file.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// `120 landmarks, 81.2 kB`, and what other runs have added.
std::string saved_text(const SharedMap::Saved& saved);

/// Saves the map of a run where that is wanted. Where there is none to save, returns the reason. A
/// run that saves into the map that it began in extends it (SharedMap), and throws as that does.
std::string save_map(const RunCommandOptions& options, const Recording& recording,
                     const CompletedRun& run);

}  // namespace chasles::app
