#pragma once

#include <filesystem>
#include <string>

#include <chasles/recording/recording.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/session/session_options.hpp>

namespace chasles {

/// Where the run's map is saved; empty: nowhere. Throws UsageError for options that exclude each
/// other.
std::filesystem::path map_target(const SessionOptions& options);

/// Throws UsageError if a map could not be saved there. Touches nothing.
void check_map_output(const std::filesystem::path& file);

/// Whether both are names of one file.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// `120 landmarks, 81.2 kB`, and what other runs have added.
std::string saved_text(const SharedMap::Saved& saved);

/// What became of a run's map: one of both, or none where no map was wanted.
struct MapOutcome {
  std::string saved;      ///< `walk.map, 120 landmarks, 81.2 kB`
  std::string not_saved;  ///< the reason
};

/// Saves the map of a run where that is wanted. A run that saves into the map that it began in
/// extends it (SharedMap), and throws as that does.
MapOutcome save_map(const SessionOptions& options, const Recording& recording,
                    const CompletedRun& run);

}  // namespace chasles
