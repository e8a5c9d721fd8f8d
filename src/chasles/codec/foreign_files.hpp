#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace chasles {

// Files that this program does not read, but that people give to it.

/// What a file with these first bytes looks like and what to do, as "looks like …: …"; none if
/// nothing is known of it.
std::optional<std::string> foreign_file(const std::filesystem::path& file,
                                        const std::string& first_bytes);

/// What stands in the place of the file that was meant, by its first bytes: a pointer of Git LFS or
/// git-annex, or a web page, with what to do. Empty for others.
std::string_view stand_in(std::string_view first_bytes);

}  // namespace chasles
