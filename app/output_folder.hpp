#pragma once

#include <filesystem>

namespace chasles::app {

/// Creates the folder and tests before the run whether files can be written to it. Throws
/// UsageError if not.
void prepare_output(const std::filesystem::path& folder);

/// Throws UsageError if the output would go among the files of the input: into the recording's own
/// folder, or into a folder within it that is not an earlier output. Links are followed. Touches
/// nothing.
void refuse_output_into(const std::filesystem::path& output,
                        const std::filesystem::path& recording);

}  // namespace chasles::app
