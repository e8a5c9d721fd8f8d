#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/loop/map_family.hpp>
#include <chasles/loop/merge_maps.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/shared_map.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// hall-2.map for hall.map, where there is none yet.
fs::path free_name_beside(const fs::path& file) {
  std::error_code ignored;
  for (int number = 2;; ++number) {
    fs::path name = file;
    name.replace_filename(
        fmt::format("{}-{}{}", file.stem().string(), number, file.extension().string()));
    if (!fs::exists(fs::symlink_status(name, ignored))) return name;
  }
}

SharedMap::Saved write_alone(const LandmarkMap& map, const fs::path& file) {
  return {.landmarks = map.points.size(), .bytes = write_map(map, file)};
}

}  // namespace

SharedMap::SharedMap(fs::path file) : file_(std::move(file)), bytes_(read_file(file_)) {
  map_ = std::make_shared<const LandmarkMap>(parse_map(bytes_, file_.string()));
}

SharedMap::Saved SharedMap::save(const LandmarkMap& extended) {
  const fs::path target = followed(file_);
  const FolderLock lock(target.has_parent_path() ? target.parent_path() : ".");
  // The numbers are those of the file, so that it does not matter which run writes it.
  own_before_ = std::exchange(own_, parse_map(map_bytes(extended), file_.string()));
  std::error_code ignored;
  if (!fs::exists(target, ignored)) return write_alone(*own_, target);
  std::string why;
  try {
    const std::string now = read_file(target);
    return now == bytes_ ? write_alone(*own_, target) : merged_with(now, target);
  } catch (const InputError& error) {
    why = error.what();
  }
  const fs::path beside = free_name_beside(file_);
  write_alone(*own_, beside);
  throw InputError(
      fmt::format("{}: has changed since the run began in it, and what the run adds cannot be "
                  "merged: the run's "
                  "map was saved as {} ({})",
                  file_.string(), beside.string(), why));
}

SharedMap::Saved SharedMap::merged_with(const std::string& now, const fs::path& target) const {
  const std::string name = file_.string();
  std::vector<LandmarkMap> there = parse_map_parts(now, name);
  if (own_before_) {
    std::erase_if(there, [&](const LandmarkMap& map) { return is_same_map(map, *own_before_); });
  }
  // A merged map whose parts are there still: the run has extended all of them.
  const std::vector<LandmarkMap> opened = parse_map_parts(bytes_, name);
  const auto is_there = [&](const LandmarkMap& part) {
    return std::ranges::any_of(there, [&](const auto& map) { return is_same_map(map, part); });
  };
  const bool all_there = opened.size() > 1 && std::ranges::all_of(opened, is_there);
  std::vector<MapPart> parts;
  for (LandmarkMap& map : there) {
    const bool extended_by_run = all_there && std::ranges::any_of(opened, [&](const auto& part) {
                                   return is_same_map(map, part);
                                 });
    if (!extended_by_run) parts.push_back({.name = name, .map = std::move(map), .file = 0});
  }
  if (!all_there) parts.push_back({.name = name, .map = *map_, .file = 0});
  parts.push_back({.name = "the map of this run", .map = *own_, .file = 0});
  const MergedMaps merged = merge_maps(std::move(parts));
  const std::size_t bytes = write_map(merged.map, target, merged.parts);
  const auto more = merged.map.sessions.size() - own_->sessions.size();
  return {.landmarks = merged.map.points.size(), .bytes = bytes, .others = static_cast<int>(more)};
}

}  // namespace chasles
