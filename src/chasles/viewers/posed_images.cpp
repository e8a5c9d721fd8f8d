#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/image_files.hpp>
#include <chasles/viewers/path_at_frames.hpp>
#include <chasles/viewers/posed_images.hpp>

namespace chasles {

PosedImages posed_images(const ReportRun& run, RunPath path, const Recording& recording) {
  const std::size_t camera = recorded_camera(run.summary, 0);
  const auto fail = [&](const std::string& found) {
    throw InputError(
        fmt::format("recording '{}' has {}, expected one with the images of camera {} as files "
                    "(docs/formats.md)",
                    recording.name, found, camera));
  };
  if (!recording.images) fail("no images");
  if (camera >= recording.cameras.size()) fail("no such camera");
  std::vector<Time> stamps;
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < recording.images->size(); ++i) {
    const std::filesystem::path file = image_file(*recording.images, i, camera);
    if (file.empty()) continue;
    stamps.push_back(recording.images->time(i));
    files.push_back(file);
  }
  if (files.empty()) fail("images that are no files, such as those of a bag");
  const SE3 imu_T_cam = imu_T_camera(run.summary, 0);
  const auto poses = poses_at_frames(run, path, stamps);
  PosedImages posed{.camera = recording.cameras[camera], .images = {}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) posed.images.push_back({.file = files[i], .world_T_cam = *poses[i] * imu_T_cam});
  }
  return posed;
}

std::vector<Eigen::Vector3d> finite_landmarks(const Run& run) {
  std::vector<Eigen::Vector3d> points;
  for (const RunLandmark& l : run.landmarks) {
    if (l.p_world.allFinite()) points.push_back(l.p_world);
  }
  return points;
}

}  // namespace chasles
