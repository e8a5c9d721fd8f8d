#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>
#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// An image of the recording, with the pose of a path.
struct PosedImage {
  std::filesystem::path file;
  SE3 world_T_cam;
};

/// The images of camera 0 of a run, in order of time, and the camera's lens.
struct PosedImages {
  Camera camera;
  std::vector<PosedImage> images;
};

/// Those with a pose (poses_at_frames). The lens is that of the recording, and imu_T_cam that of
/// the summary. Throws InputError as these do, and for a recording whose images are no files.
PosedImages posed_images(const ReportRun& run, RunPath path, const Recording& recording);

/// The positions of the landmarks that are finite, in the world of the run [m].
std::vector<Eigen::Vector3d> finite_landmarks(const Run& run);

}  // namespace chasles
