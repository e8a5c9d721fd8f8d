#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace chasles::fuzz {

/// A way into the readers: bytes become a file (or several), which is then read.
struct Kind {
  std::string_view name;
  /// The bytes of a small valid recording; `scratch` is a folder to make it in.
  std::string (*seed)(const std::filesystem::path& scratch);
  /// Writes the bytes below `scratch` and reads them. Throws InputError where they are malformed,
  /// and must do nothing worse whatever they are.
  void (*read)(const std::filesystem::path& scratch, std::string_view bytes);
};

/// All of them. A kind that is one file takes its bytes; `npy` the
/// arrays of an archive, `png` an image (both with the right check sums put in); those that are
/// several files take "=== NAME" parts.
std::vector<Kind> kinds();

/// Those of one file of kinds each.
std::vector<Kind> drive_kinds();         ///< body velocities and tracks
std::vector<Kind> inertial_kinds();      ///< samples of an IMU, and tracks
std::vector<Kind> image_folder_kinds();  ///< samples of an IMU, and images
std::vector<Kind> single_file_kinds();   ///< images, trajectories, settings

/// Makes a folder of this process' own, in memory where the system has that.
std::filesystem::path make_scratch();

}  // namespace chasles::fuzz
