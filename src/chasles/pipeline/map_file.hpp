#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <chasles/map/landmark_map.hpp>

// Maps as files (docs/formats.md, "Maps").
namespace chasles {

/// The bytes of a file. Directions of views and covariances are rounded to what the file stores.
/// Throws UsageError for a landmark that is not finite or has no view.
std::string map_bytes(const LandmarkMap& map);

/// Replaces the file as a whole: after a kill or a full disk it is the old one or the new one.
/// Returns its size. Throws UsageError where it cannot be written, and as map_bytes().
std::size_t write_map(const LandmarkMap& map, const std::filesystem::path& file);

/// Throws InputError for what is no map, a map of another version, and a damaged one, with what was
/// found. `name` is the file's, for messages.
LandmarkMap parse_map(std::string_view bytes, const std::string& name);
LandmarkMap read_map(const std::filesystem::path& file);

}  // namespace chasles
