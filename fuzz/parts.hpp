#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace chasles::fuzz {

/// Files of a folder, name (with `/` for folders below) and bytes, as one text of "=== NAME" lines.
using Parts = std::vector<std::pair<std::string, std::string>>;

std::string pack(const Parts& parts);

/// What pack() made, whatever a mutation made of that: the names stay inside a folder.
Parts unpack(std::string_view bytes);

/// All files in and below a folder, by name.
Parts parts_of(const std::filesystem::path& folder);

/// Makes `folder` hold what the bytes say, and nothing else.
void lay_out(const std::filesystem::path& folder, std::string_view bytes);

}  // namespace chasles::fuzz
