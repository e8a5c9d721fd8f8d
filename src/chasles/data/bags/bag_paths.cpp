#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/bags/bag_paths.hpp>
#include <chasles/data/folder_names.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";
constexpr const char* kInformation = "rosbag2_bagfile_information";

bool is_bag_name(const fs::path& file) {
  constexpr std::array endings{".bag", ".active", ".db3", ".mcap", ".zstd"};
  const std::string name = file.filename().string();
  if (name.starts_with(".")) return false;  // ._walk.bag of macOS
  const std::string ending = file.extension().string();
  // walk.bag.active and walk.db3.zstd
  const bool two = ending != ".active" && ending != ".zstd";
  return std::find(endings.begin(), endings.end(), ending) != endings.end() &&
         (two || is_bag_name(file.stem()));
}

std::vector<fs::path> bags_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored) && is_bag_name(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The files that metadata.yaml lists. Its paths are relative to the folder; old ones begin with the
// folder's name.
std::vector<fs::path> listed_files(const fs::path& folder, std::vector<std::string>& remarks) {
  const YamlMap all = YamlMap::read(folder / kMetadata, {.known = {}, .needed = {kInformation}});
  const YamlMap map = all.map(kInformation, {.known = {}, .needed = {"relative_file_paths"}});
  std::vector<fs::path> files;
  for (const std::string& name : map.texts("relative_file_paths")) {
    const fs::path file = folder / fs::path(name).filename();
    if (fs::exists(file)) {
      files.push_back(file);
    } else {
      remarks.push_back(fmt::format("{} lists {}, which is not there: left out",
                                    (folder / kMetadata).string(), name));
    }
  }
  return files;
}

}  // namespace

bool is_bag_folder(const fs::path& folder) {
  return !bags_in(folder).empty() || fs::exists(folder / kMetadata);
}

BagPaths find_bag_files(const fs::path& path) {
  BagPaths paths;
  const bool folder = fs::is_directory(path);
  const fs::path home = folder ? path : path.has_parent_path() ? path.parent_path() : fs::path(".");
  paths.folders.push_back(home);
  if (fs::exists(home / kMetadata)) paths.folders.push_back(home / "..");
  if (!folder) {
    paths.name = path.stem().string();
    paths.files = {path};
    return paths;
  }
  paths.name = folder_name(path);
  if (fs::exists(path / kMetadata)) paths.files = listed_files(path, paths.remarks);
  if (paths.files.empty()) paths.files = bags_in(path);
  if (paths.files.empty()) {
    throw InputError(path.string() +
                     ": has a metadata.yaml of a ROS 2 bag, but there is no .db3 or "
                     ".mcap file, expected those that it lists");
  }
  return paths;
}

}  // namespace chasles
