#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/loop/landmark_map.hpp>

// Maps as files (docs/formats.md, "Maps").
namespace chasles {

/// The bytes of a file. `parts` are the maps of which the map was merged, none for another one.
/// Directions of views and covariances are rounded to what the file stores. Throws UsageError for a
/// landmark that is not finite or has no view.
std::string map_bytes(const LandmarkMap& map, std::span<const LandmarkMap> parts = {});

/// Replaces the file as a whole: after a kill or a full disk it is the old one or the new one.
/// Returns its size. Throws UsageError where it cannot be written, and as map_bytes().
std::size_t write_map(const LandmarkMap& map, const std::filesystem::path& file,
                      std::span<const LandmarkMap> parts = {});

/// Throws InputError for what is no map, a map of another version, and a damaged one, with what was
/// found. `name` is the file's, for messages. What was read is written as the same bytes again.
LandmarkMap parse_map(std::string_view bytes, const std::string& name);
LandmarkMap read_map(const std::filesystem::path& file);

/// The maps of which a map was merged; of one that was not merged, the map itself. Throws as
/// parse_map().
std::vector<LandmarkMap> parse_map_parts(std::string_view bytes, const std::string& name);
std::vector<LandmarkMap> read_map_parts(const std::filesystem::path& file);

}  // namespace chasles
