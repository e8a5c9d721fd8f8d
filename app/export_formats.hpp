#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/reconstruct/colmap_settings.hpp>
#include <chasles/reconstruct/undistorted_images.hpp>
#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles::app {

/// What the formats of `chasles export` may ask for.
struct ExportChoice {
  RunPath path = RunPath::kStates;
  bool points = false;              ///< of a PLY
  std::filesystem::path output;     ///< of -o
  std::filesystem::path recording;  ///< of the run, for its frames; empty: not given
  ColmapSettings colmap = {};
  bool undistort = false;        ///< images of pinhole cameras
  std::string body = "x,-y,-z";  ///< the vehicle's axes (frd_R_imu)
};

/// A file of a format that has a folder of them; of others the only one, without a name.
struct ExportedFile {
  std::string name;
  std::string bytes;
};

/// The files of an export, sentences for the user, and images that are made while they are written.
struct Exported {
  std::vector<ExportedFile> files;
  std::vector<std::string> remarks = {};
  std::optional<UndistortedImages> images = {};
};

/// A format of `chasles export`.
struct ExportFormat {
  std::string_view name;    ///< of --as
  std::string_view ending;  ///< of the file of -o, which chooses it without --as; empty: none does
  std::string_view use;     ///< one line for the help
  bool has_path;            ///< of the states alone, which may be at other times
  bool is_folder;           ///< -o is a folder; the first file marks a complete set
  Exported (*make)(const ReportRun& run, const ExportChoice& choice);
};

/// All formats. This list feeds the option, the help and the messages.
const std::vector<ExportFormat>& export_formats();

/// The format of --as, or without one that of the file's ending. Throws UsageError.
const ExportFormat& export_format(std::string_view name, const std::filesystem::path& output);

/// "mcap|ply|...".
std::string export_names();
/// "square, tum, ...": those with has_path.
std::string names_of_paths();
/// For the help: one sentence on each ending, or on each other name.
std::string export_endings_help();
std::string export_names_help();

}  // namespace chasles::app
