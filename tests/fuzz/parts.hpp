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

/// Unpacks the output of pack(), possibly mutated; the names stay inside a folder.
Parts unpack(std::string_view bytes);

/// All files in and below a folder, by name.
Parts parts_of(const std::filesystem::path& folder);

/// Replaces the content of `folder` by the parts.
void lay_out(const std::filesystem::path& folder, std::string_view bytes);

}  // namespace chasles::fuzz
