#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace chasles {

/// The files of a bag, and what belongs to it.
struct BagPaths {
  std::string name;                            ///< of the recording
  std::vector<std::filesystem::path> files;    ///< at least one
  std::vector<std::filesystem::path> folders;  ///< where calibration may be, the nearest first
  /// Whether the last of them is the folder above one without metadata.yaml: a remark is due on
  /// what is taken from there.
  bool above = false;
  std::vector<std::string> remarks;
};

/// Whether a folder is that of a bag: metadata.yaml of rosbag2, or files .bag, .db3 or .mcap, which
/// may be compressed as a whole (.mcap.zstd, .bag.gz).
bool is_bag_folder(const std::filesystem::path& folder);

/// The files of a path that is a bag's file, or a folder with bags: those that metadata.yaml of
/// rosbag2 lists, else all of them. Of a file and its compressed copy (walk.mcap, walk.mcap.zstd)
/// the plain one is taken, whichever is listed. Throws InputError if there are none.
BagPaths find_bag_files(const std::filesystem::path& path);

}  // namespace chasles
