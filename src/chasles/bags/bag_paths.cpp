#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/bags/bag_paths.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";
constexpr const char* kInformation = "rosbag2_bagfile_information";

bool is_bag_name(const fs::path& file) {
  constexpr std::array endings{".bag", ".active", ".db3", ".mcap"};
  if (file.filename().string().starts_with(".")) return false;  // ._walk.bag of macOS
  const fs::path plain = unpacked_name(file);
  const std::string ending = plain.extension().string();
  if (ending == ".active") return is_bag_name(plain.stem());  // walk.bag.active
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
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

// The compressed forms of a plain file that are there.
std::vector<fs::path> packed_copies(const fs::path& plain) {
  std::vector<fs::path> copies;
  for (const char* ending : {".zstd", ".zst", ".gz", ".bz2", ".lz4"}) {
    const fs::path copy = plain.string() + ending;
    if (fs::exists(copy)) copies.push_back(copy);
  }
  return copies;
}

// The form of a listed file that is there: plain (as after `zstd -d`), or compressed; none.
fs::path form_of(const fs::path& listed) {
  const fs::path plain = unpacked_name(listed);
  if (fs::exists(plain)) return plain;
  if (fs::exists(listed)) return listed;
  const std::vector<fs::path> copies = packed_copies(plain);
  return copies.empty() ? fs::path() : copies.front();
}

// Leaves out compressed files whose plain form is there too.
void leave_out_copies(std::vector<fs::path>& files, std::vector<std::string>& remarks) {
  std::erase_if(files, [&](const fs::path& file) {
    const fs::path plain = unpacked_name(file);
    if (plain == file || !fs::exists(plain)) return false;
    remarks.push_back(fmt::format("{} is there beside {}: the plain one is read", plain.string(),
                                  file.filename().string()));
    return true;
  });
}

// The files that metadata.yaml lists. Its paths are relative to the folder; old ones begin with the
// folder's name.
std::vector<fs::path> listed_files(const fs::path& folder, std::vector<std::string>& remarks) {
  const YamlMap all = YamlMap::read(folder / kMetadata, {.known = {}, .needed = {kInformation}});
  const YamlMap map = all.map(kInformation, {.known = {}, .needed = {"relative_file_paths"}});
  std::vector<fs::path> files;
  for (const std::string& name : map.texts("relative_file_paths")) {
    const fs::path listed = folder / fs::path(name).filename(), file = form_of(listed);
    if (!file.empty()) {
      files.push_back(file);
      if (file == listed) continue;
      remarks.push_back(fmt::format("{} lists {}; {} is there, and is read",
                                    (folder / kMetadata).string(), name, file.filename().string()));
    } else {
      remarks.push_back(fmt::format("{} lists {}, which is not there: left out",
                                    (folder / kMetadata).string(), name));
    }
  }
  return files;
}

// walk/walk_0.mcap: `ros2 bag record` makes the folder, and writes metadata.yaml at its end.
bool is_part_of_its_folder(const fs::path& file, const fs::path& folder) {
  const fs::path plain = unpacked_name(file);
  const std::string ending = plain.extension().string(), name = plain.stem().string();
  return (ending == ".mcap" || ending == ".db3") && name.starts_with(folder_name(folder) + "_");
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
  const bool listed = fs::exists(home / kMetadata);
  paths.above = !listed && (folder || is_part_of_its_folder(path, home));
  if (listed || paths.above) paths.folders.push_back(home / "..");
  if (!folder) {
    paths.name = unpacked_name(path).stem().string();
    paths.files = {path};
    return paths;
  }
  paths.name = folder_name(path);
  if (listed) paths.files = listed_files(path, paths.remarks);
  if (paths.files.empty()) {
    paths.files = bags_in(path);
    leave_out_copies(paths.files, paths.remarks);
  }
  if (paths.files.empty()) {
    throw InputError(path.string() +
                     ": has a metadata.yaml of a ROS 2 bag, but there is no .db3 or "
                     ".mcap file, expected those that it lists");
  }
  return paths;
}

}  // namespace chasles
