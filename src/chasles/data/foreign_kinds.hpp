#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace chasles {

// Files and folders that are no recording for this program, but that people give to it.

/// What a folder looks like and what to do, as "looks like …: …"; none if nothing is known of it.
std::optional<std::string> foreign_folder(const std::filesystem::path& folder);

/// The same for a file with these first bytes.
std::optional<std::string> foreign_file(const std::filesystem::path& file,
                                        const std::string& first_bytes);

}  // namespace chasles
