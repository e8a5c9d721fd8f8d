#pragma once

#include <filesystem>

namespace chasles::app {

/// Makes the folder and finds out whether files can be written to it, before an hour of work is
/// lost. Throws UsageError where not.
void prepare_output(const std::filesystem::path& folder);

}  // namespace chasles::app
