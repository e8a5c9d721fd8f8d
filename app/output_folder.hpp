#pragma once

#include <filesystem>

namespace chasles::app {

/// Creates the folder and tests before the run whether files can be written to it. Throws
/// UsageError if not.
void prepare_output(const std::filesystem::path& folder);

}  // namespace chasles::app
