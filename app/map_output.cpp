#include "map_output.hpp"

#include <unistd.h>

#include <fmt/format.h>
#include <sys/stat.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/pipeline/map_file.hpp>

#include "print.hpp"

namespace chasles::app {

namespace fs = std::filesystem;

fs::path map_target(const RunCommandOptions& o) {
  if (o.extend && !o.save_map.empty()) {
    throw UsageError(
        "--extend saves into the file of --map, --save-map into another one: expected one of them");
  }
  return o.extend ? o.map : o.save_map;
}

void check_map_output(const fs::path& name) {
  if (name.empty()) return;
  reject_pipe(name);
  std::error_code ignored;
  const fs::path file = fs::exists(name, ignored) ? name : followed(name);
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (fs::is_directory(file, ignored)) {
    throw UsageError(file.string() + ": is a folder, expected the name of a file for the map");
  }
  struct stat status {};
  if (::stat(folder.c_str(), &status) == 0 && status.st_nlink == 0) {
    throw UsageError(file.string() + ": cannot be written: its folder was removed");
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

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  const fs::path of_a = fs::weakly_canonical(fs::absolute(a, error), error);
  const fs::path of_b = fs::weakly_canonical(fs::absolute(b, error), error);
  return a == b || (!error && of_a == of_b);
}

std::string saved_text(const SharedMap::Saved& saved) {
  std::string text = fmt::format("{} landmarks, {:.1f} kB", saved.landmarks,
                                 1e-3 * static_cast<double>(saved.bytes));
  if (saved.others > 0) {
    text += fmt::format(", with {} session{} that other runs added meanwhile", saved.others,
                        saved.others == 1 ? "" : "s");
  }
  return text;
}

std::string save_map(const RunCommandOptions& o, const Recording& recording,
                     const CompletedRun& run) {
  const fs::path file = map_target(o);
  if (file.empty()) return {};
  std::optional<LandmarkMap> map = run.estimator->landmark_map();
  if (run.map && (!map || map->sessions.size() <= run.map->map()->sessions.size())) {
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
  SharedMap::Saved saved;
  if (run.map && is_same_file(file, o.map)) {
    saved = run.map->save(*map);
  } else {
    saved = {.landmarks = map->points.size(), .bytes = write_map(*map, file)};
  }
  if (!o.quiet && !o.json) app::print("map: {}, {}\n", file.string(), saved_text(saved));
  return {};
}

}  // namespace chasles::app
