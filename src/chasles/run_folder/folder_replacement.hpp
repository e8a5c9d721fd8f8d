#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

namespace chasles {

/// New files of a run folder, which replace those of an earlier run all together. They are written
/// into its subfolder `.writing`. commit() renames that to `.written`: from this instant they are
/// the run. Then they move up one by one, summary.json last; if the process ends on the way, the
/// next reader or writer moves the others (finish_replacement). Other files of the folder stay.
///
/// Every step is on the disk before the next begins (fsync), so that the same holds after a power
/// cut.
class FolderReplacement {
 public:
  /// Creates the folder if it is missing. Throws UsageError if it cannot be written.
  explicit FolderReplacement(const std::filesystem::path& folder);
  FolderReplacement(const FolderReplacement&) = delete;
  FolderReplacement& operator=(const FolderReplacement&) = delete;
  ~FolderReplacement();  ///< without commit(), removes the new files

  /// Where the new files belong.
  const std::filesystem::path& place() const { return writing_; }

  /// Adds the entry `files` to the summary, the size and check sum of every file, and writes it.
  /// Replaces the run. Returns the summary as written. Throws UsageError.
  nlohmann::ordered_json commit(nlohmann::ordered_json summary);

 private:
  std::filesystem::path folder_, writing_;
};

/// Ends the replacement of a run that a killed process began: moves committed files up, otherwise
/// does nothing. Throws InputError if that is not possible.
void finish_replacement(const std::filesystem::path& folder);

/// Removes what a process left that was killed before commit().
void discard_unfinished(const std::filesystem::path& folder);

/// Compares the files with the entry `files` of summary.json, if there is one. Throws InputError
/// for a file that is missing, truncated, changed, or of another run.
void check_run_files(const std::filesystem::path& folder, const nlohmann::ordered_json& summary);

}  // namespace chasles
