#include "export_formats.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/reconstruct/run_colmap.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/viewers/kml.hpp>
#include <chasles/viewers/mavlink.hpp>
#include <chasles/viewers/mps.hpp>
#include <chasles/viewers/nerfstudio.hpp>
#include <chasles/viewers/path_files.hpp>
#include <chasles/viewers/ply.hpp>
#include <chasles/viewers/run_mcap.hpp>
#include <chasles/viewers/square.hpp>
#include <chasles/viewers/umi.hpp>

namespace chasles::app {
namespace {

Exported one_file(std::string bytes) {
  return {.files = {{.name = {}, .bytes = std::move(bytes)}}};
}

Exported kitti_files(const ReportRun& run, const ExportChoice& choice) {
  KittiFiles kitti = run_kitti(run, choice.path);
  return {.files = {{"poses.txt", std::move(kitti.poses)}, {"times.txt", std::move(kitti.times)}}};
}

Exported mps_files(const ReportRun& run, const ExportChoice& choice) {
  MpsFiles mps = run_mps(run, choice.path);
  return {.files = {{"closed_loop_trajectory.csv", std::move(mps.trajectory)},
                    {"semidense_points.csv.gz", std::move(mps.points)}}};
}

Recording recording_for(const char* format, const ExportChoice& choice) {
  if (!choice.recording.empty()) return read_recording(choice.recording);
  throw UsageError(
      fmt::format("--as {}: the run folder does not have the frames of its recording, expected "
                  "--recording with it",
                  format));
}

// The stamps of all frames of the run's first camera.
std::vector<Time> stamps_of_camera(const Recording& recording, std::string_view summary) {
  const std::size_t camera = recorded_camera(summary, 0);
  std::vector<Time> stamps;
  for (const FeatureFrame& frame : recording.frames) stamps.push_back(frame.time);
  for (std::size_t i = 0; recording.images && i < recording.images->size(); ++i) {
    if (recording.images->has_image(i, camera)) stamps.push_back(recording.images->time(i));
  }
  return stamps;
}

Exported nerfstudio_files(const ReportRun& run, const ExportChoice& choice) {
  const Recording recording = recording_for("nerfstudio", choice);
  const auto exported = [&](const PosedImages& posed) -> Exported {
    NerfstudioFiles nerfstudio = run_nerfstudio(run.run, posed, choice.output);
    return {.files = {{"transforms.json", std::move(nerfstudio.transforms)},
                      {"sparse_pc.ply", std::move(nerfstudio.points)}}};
  };
  if (!choice.undistort) return exported(posed_images(run, choice.path, recording));
  PosedUndistorted undistorted = posed_undistorted(run, choice.path, recording, choice.output);
  Exported result = exported(undistorted.posed);
  result.images = std::move(undistorted.images);
  return result;
}

// The folder from which the names of a recording's files are relative.
std::filesystem::path folder_of(const std::filesystem::path& recording) {
  return std::filesystem::is_directory(recording) ? recording : recording.parent_path();
}

Exported colmap_files(const char* format, ColmapFiles (*write)(const ColmapModel&),
                      const ReportRun& run, const ExportChoice& choice) {
  RunColmap colmap = run_colmap(
      run, choice.path, recording_for(format, choice),
      {.folder = folder_of(choice.recording), .undistort = choice.undistort}, choice.colmap);
  Exported exported{
      .files = {}, .remarks = std::move(colmap.remarks), .images = std::move(colmap.images)};
  for (auto& [name, bytes] : write(colmap.model)) {
    exported.files.push_back({.name = name, .bytes = std::move(bytes)});
  }
  exported.files.push_back({.name = "database.db", .bytes = colmap_database(colmap.model)});
  return exported;
}

Exported colmap_text_files(const ReportRun& run, const ExportChoice& choice) {
  if (std::filesystem::exists(choice.output / "cameras.bin")) {
    throw UsageError(
        fmt::format("--as colmap-text: {} has a binary model, which COLMAP reads instead, expected "
                    "another folder",
                    choice.output.string()));
  }
  return colmap_files("colmap-text", &colmap_text, run, choice);
}

std::vector<std::string> names_where(bool has_ending) {
  std::vector<std::string> names;
  for (const ExportFormat& format : export_formats()) {
    if (format.ending.empty() == has_ending) continue;
    names.emplace_back(has_ending ? format.ending : format.name);
  }
  return names;
}

}  // namespace

const std::vector<ExportFormat>& export_formats() {
  static const std::vector<ExportFormat> formats{
      {"mcap", ".mcap", "for Foxglove and Rerun", false, false,
       [](const ReportRun& r, const ExportChoice&) {
         return one_file(run_mcap(r, CHASLES_VERSION));
       }},
      {"ply", ".ply", "map and trajectories, for CloudCompare, MeshLab, Blender", false, false,
       [](const ReportRun& r, const ExportChoice& c) {
         return one_file(run_ply(r.run, c.points ? PlyEdges::kNo : PlyEdges::kYes));
       }},
      {"kml", ".kml", "trajectories on the Earth, for a georeferenced recording", false, false,
       [](const ReportRun& r, const ExportChoice&) { return one_file(run_kml(r.run)); }},
      {"square", ".square", "poses with covariances, for smfeval", true, false,
       [](const ReportRun& r, const ExportChoice& c) {
         return one_file(run_square(r.run, c.path, CHASLES_VERSION));
       }},
      {"tum", ".tum", "poses, for evo", true, false,
       [](const ReportRun& r, const ExportChoice& c) { return one_file(run_tum(r.run, c.path)); }},
      {"mavlink", ".tlog", "messages ODOMETRY of MAVLink, for pymavlink and autopilots", true,
       false,
       [](const ReportRun& r, const ExportChoice& c) {
         return one_file(mavlink_log(frd_odometry(r, c.path, frd_R_imu(c.body))));
       }},
      {"kitti", "", "folder with poses.txt and times.txt of camera 0", true, true, &kitti_files},
      {"euroc", "", "table like EuRoC's state_groundtruth_estimate0", true, false,
       [](const ReportRun& r, const ExportChoice& c) {
         return one_file(run_euroc(r.run, c.path));
       }},
      {"mps", "", "folder with trajectory and points for projectaria-tools", true, true,
       &mps_files},
      {"nerfstudio", "", "folder with transforms.json and points for nerfstudio", false, true,
       &nerfstudio_files},
      {"colmap", "", "folder with a model and a database for COLMAP", false, true,
       [](const ReportRun& r, const ExportChoice& c) {
         return colmap_files("colmap", &colmap_binary, r, c);
       }},
      {"colmap-text", "", "the same as text", false, true, &colmap_text_files},
      {"umi", "", "camera_trajectory.csv of UMI's SLAM pipeline", false, false,
       [](const ReportRun& r, const ExportChoice& c) {
         return one_file(run_umi(r, c.path, stamps_of_camera(recording_for("umi", c), r.summary)));
       }},
  };
  return formats;
}

const ExportFormat& export_format(std::string_view name, const std::filesystem::path& output) {
  const auto& formats = export_formats();
  if (!name.empty()) {
    const auto found = std::ranges::find(formats, name, &ExportFormat::name);
    if (found != formats.end()) return *found;
    throw UsageError(fmt::format("--as: found '{}', expected {}", name, export_names()));
  }
  const std::string ending = output.extension().string();
  const auto found = std::ranges::find(formats, ending, &ExportFormat::ending);
  if (!ending.empty() && found != formats.end()) return *found;
  throw UsageError(fmt::format("-o: {} ends with '{}', expected {}, or --as with one of {}",
                               output.string(), ending, fmt::join(names_where(true), ", "),
                               fmt::join(names_where(false), ", ")));
}

std::string export_names() {
  std::vector<std::string_view> names;
  for (const ExportFormat& format : export_formats()) names.push_back(format.name);
  return fmt::format("{}", fmt::join(names, "|"));
}

std::string names_of_paths() {
  std::vector<std::string_view> names;
  for (const ExportFormat& format : export_formats()) {
    if (format.has_path) names.push_back(format.name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string export_endings_help() {
  std::string text;
  for (const ExportFormat& format : export_formats()) {
    if (format.ending.empty()) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", format.ending, format.use);
  }
  return text;
}

std::string export_names_help() {
  std::string text;
  for (const ExportFormat& format : export_formats()) {
    if (!format.ending.empty()) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", format.name, format.use);
  }
  return text;
}

}  // namespace chasles::app
