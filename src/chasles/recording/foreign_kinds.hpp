#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace chasles {

// Folders that are no recording for this program, but that people give to it. Files:
// codec/foreign_files.hpp.

/// What a folder looks like and what to do, as "looks like …: …"; none if nothing is known of it.
std::optional<std::string> foreign_folder(const std::filesystem::path& folder);

}  // namespace chasles
