#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/recording/recording.hpp>
#include <chasles/report/report.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

/// The place of the camera with this number in the calibration among those of the recording; none
/// there: as many as it has, or more.
std::size_t place_of_camera(const Recording& recording, std::size_t number);

/// The image files of a camera, in order of time.
struct CameraImages {
  Camera camera;  ///< as the recording states it
  std::vector<Time> stamps = {};
  std::vector<std::filesystem::path> files = {};
};

/// Those of the camera with this number in the calibration. Throws InputError for a recording
/// without that camera, or whose images are no files.
CameraImages camera_images(const Recording& recording, std::size_t camera);

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
/// the summary. Throws InputError as these and camera_images() do.
PosedImages posed_images(const ReportRun& run, RunPath path, const Recording& recording);

/// The positions of the landmarks that are finite, in the world of the run [m].
std::vector<Eigen::Vector3d> finite_landmarks(const Run& run);

}  // namespace chasles
