#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <chasles/reconstruct/colmap_settings.hpp>
#include <chasles/reconstruct/undistorted_images.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/report/report.hpp>
#include <chasles/viewers/colmap.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// A model of a run for COLMAP, and sentences for the user.
struct RunColmap {
  ColmapModel model;
  std::vector<std::string> remarks = {};
  std::optional<UndistortedImages> images = {};  ///< to be written beside it; none: the recording's
};

/// Whose images a model has.
struct ModelImages {
  std::filesystem::path folder;  ///< of the recording's files: their names are relative to it
  bool undistort = false;        ///< new ones of pinhole cameras, images/camN/NS.png, instead
};

/// Tracks the images of the run's cameras again, chooses keyframes among those with a pose, and
/// triangulates the tracks. The poses are those of the path; with a rolling shutter, that of the
/// middle line of the first camera, as COLMAP's cameras have a global one. The cameras are
/// those of the recording, with the imu_T_cam of the summary. With `undistort` they are pinhole
/// cameras, and the recording's images need not be files; names are then relative to images/. Needs
/// 5 kB a frame of the recording. Throws InputError as poses_at_frames() and camera_images() do,
/// for settings in the summary that are none, and for a run of which no track is a point.
RunColmap run_colmap(const ReportRun& run, RunPath path, Recording recording,
                     const ModelImages& images, const ColmapSettings& settings);

}  // namespace chasles
