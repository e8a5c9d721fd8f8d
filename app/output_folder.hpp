#pragma once

#include <filesystem>
#include <vector>

namespace chasles::app {

/// Creates the folder and tests before the run whether files can be written to it. Throws
/// UsageError if not. Returns the folders that it has created, the outermost first.
std::vector<std::filesystem::path> prepare_output(const std::filesystem::path& folder);

/// Holds an output against other processes of this machine, until its end or that of the process:
/// its forks do not hold it. On a file system without locks it has no effect. One at a time.
class OutputLock {
 public:
  /// `held`: the folder, or a file in it, which is created if `create`. Throws UsageError where
  /// another process holds it.
  OutputLock(const std::filesystem::path& held, bool create = false);
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  ~OutputLock();

 private:
  int descriptor_;
  bool listed_ = false;  ///< among those that forks close
};

/// Throws UsageError if the output would go among the files of the input: into the recording's own
/// folder, or into a folder within it that is not an earlier output. Links are followed. Touches
/// nothing.
void reject_output_into(const std::filesystem::path& output,
                        const std::filesystem::path& recording);

}  // namespace chasles::app
