#pragma once

#include <filesystem>
#include <string>

namespace chasles {

/// The last part of a folder's path, also of "some/folder/", "." and "..".
inline std::string folder_name(const std::filesystem::path& folder) {
  std::error_code ignored;
  const std::filesystem::path path = std::filesystem::weakly_canonical(folder, ignored);
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace chasles
