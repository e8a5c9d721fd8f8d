#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace chasles::fuzz {

/// An entry into the readers: bytes become one or several files, which are then read.
struct Kind {
  std::string_view name;
  /// The bytes of a small valid recording; `scratch` is a folder for temporary files.
  std::string (*seed)(const std::filesystem::path& scratch);
  /// Writes the bytes below `scratch` and reads them. Throws InputError if they are malformed; for
  /// any input it must do nothing worse.
  void (*read)(const std::filesystem::path& scratch, std::string_view bytes);
};

/// All kinds. A kind of one file takes its bytes; `npy` the arrays of an archive, `png` an image
/// (both with corrected check sums), `png_pixels` its header and pixels; kinds of several files
/// take "=== NAME" parts.
std::vector<Kind> kinds();

/// The kinds of one source file each.
std::vector<Kind> velocity_kinds();      ///< body velocities and tracks
std::vector<Kind> inertial_kinds();      ///< samples of an IMU, and tracks
std::vector<Kind> image_folder_kinds();  ///< samples of an IMU, and images
std::vector<Kind> rig_kinds();           ///< calibrations of many cameras, with their lenses
std::vector<Kind> bag_kinds();           ///< bags of ROS, their messages and chunks
std::vector<Kind> video_kinds();         ///< videos, their telemetry, and JSON beside them
std::vector<Kind> single_file_kinds();   ///< images, trajectories, settings

/// Creates a folder for this process, in memory if the system supports that.
std::filesystem::path make_scratch();

}  // namespace chasles::fuzz
