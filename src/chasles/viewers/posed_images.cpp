#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/image_files.hpp>
#include <chasles/viewers/path_at_frames.hpp>
#include <chasles/viewers/posed_images.hpp>

namespace chasles {

std::size_t place_of_camera(const Recording& recording, std::size_t number) {
  const std::vector<std::size_t>& numbers = recording.camera_numbers;
  if (numbers.empty()) return number;
  return static_cast<std::size_t>(std::ranges::find(numbers, number) - numbers.begin());
}

CameraImages camera_images(const Recording& recording, std::size_t camera) {
  const auto fail = [&](const std::string& found) {
    throw InputError(
        fmt::format("recording '{}' has {}, expected one with the images of camera {} as files "
                    "(docs/formats.md)",
                    recording.name, found, camera));
  };
  if (!recording.images) fail("no images");
  const std::size_t place = place_of_camera(recording, camera);
  if (place >= recording.cameras.size()) fail("no such camera");
  CameraImages all{.camera = recording.cameras[place]};
  for (std::size_t i = 0; i < recording.images->size(); ++i) {
    const std::filesystem::path file = image_file(*recording.images, i, place);
    if (file.empty()) continue;
    all.stamps.push_back(recording.images->time(i));
    all.files.push_back(file);
  }
  if (all.files.empty()) fail("images that are no files, such as those of a bag");
  return all;
}

PosedImages posed_images(const ReportRun& run, RunPath path, const Recording& recording) {
  const CameraImages images = camera_images(recording, recorded_camera(run.summary, 0));
  const SE3 imu_T_cam = imu_T_camera(run.summary, 0);
  const auto poses = poses_at_frames(run, path, images.stamps);
  PosedImages posed{.camera = images.camera, .images = {}};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    posed.images.push_back(
        {.file = images.files[i], .world_T_cam = poses[i]->world_T_imu * imu_T_cam});
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
