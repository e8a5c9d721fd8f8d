#include "map_output.hpp"

#include <unistd.h>

#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/pipeline/map_file.hpp>

namespace chasles::app {

namespace fs = std::filesystem;

fs::path map_target(const RunCommandOptions& o) {
  if (o.extend && !o.save_map.empty()) {
    throw UsageError(
        "--extend saves into the file of --map, --save-map into another one: expected one of them");
  }
  return o.extend ? o.map : o.save_map;
}

void check_map_output(const fs::path& file) {
  if (file.empty()) return;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    throw UsageError(file.string() + ": is a folder, expected the name of a file for the map");
  }
  if (!fs::is_directory(folder, ignored)) {
    throw UsageError(fmt::format("{}: cannot be written: there is no folder {}", file.string(),
                                 folder.string()));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw UsageError(fmt::format("{}: cannot be written: no right to write into {}", file.string(),
                                 folder.string()));
  }
}

std::string save_map(const RunCommandOptions& o, const Recording& recording,
                     const Estimator& estimator) {
  const fs::path file = map_target(o);
  if (file.empty()) return {};
  std::optional<LandmarkMap> map = estimator.landmark_map();
  if (!o.map.empty() && (!map || map->sessions.size() <= read_map(o.map).sessions.size())) {
    return fmt::format(
        "{}: the run found no place in {}, so there is nothing to add to it: no map was saved",
        file.string(), o.map.string());
  }
  if (!map || map->points.empty()) {
    return fmt::format("{}: the run has no landmark that could be recognised: no map was saved",
                       file.string());
  }
  for (MapSession& session : map->sessions) {
    if (session.name.empty()) session.name = recording.name;
  }
  const std::size_t bytes = write_map(*map, file);
  if (!o.quiet && !o.json) {
    fmt::print("map: {}, {} landmarks, {:.1f} kB\n", file.string(), map->points.size(),
               1e-3 * static_cast<double>(bytes));
  }
  return {};
}

}  // namespace chasles::app
