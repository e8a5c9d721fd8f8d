#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/reconstruct/undistorted_images.hpp>
#include <chasles/viewers/path_at_frames.hpp>

namespace chasles {

void UndistortedImages::write(const AddFile& add) const {
  for (const Wanted& one : wanted_) {
    const ImageFrame frame =
        images_->read_chosen(one.frame, {one.camera}, [](const InputError& error) { throw error; });
    if (frame.images.front().empty()) {
      throw InputError(fmt::format("the image {} cannot be read, expected one", one.name));
    }
    add(one.name, png_bytes(lenses_[one.camera].image(frame.images.front())));
  }
}

std::vector<Undistortion> undistortions(const std::vector<Camera>& cameras) {
  std::vector<Undistortion> all;
  for (const Camera& camera : cameras) all.emplace_back(camera);
  return all;
}

std::string image_name(Time time) { return fmt::format("{}.png", time.count()); }

PosedUndistorted posed_undistorted(const ReportRun& run, RunPath path, const Recording& recording,
                                   const std::filesystem::path& folder) {
  const std::size_t number = recorded_camera(run.summary, 0);
  const std::size_t camera = place_of_camera(recording, number);
  if (!recording.images || camera >= recording.cameras.size()) {
    throw InputError(fmt::format("recording '{}' has no images of camera {}, expected the run's",
                                 recording.name, number));
  }
  std::vector<std::size_t> frames;
  std::vector<Time> stamps;
  for (std::size_t i = 0; i < recording.images->size(); ++i) {
    if (!recording.images->has_image(i, camera)) continue;
    frames.push_back(i);
    stamps.push_back(recording.images->time(i));
  }
  const SE3 imu_T_cam = imu_T_camera(run.summary, 0);
  PosedUndistorted result{.posed = {},
                          .images = {recording.images, undistortions(recording.cameras)}};
  result.posed.camera = result.images.camera(camera);
  const auto poses = poses_at_frames(run, path, stamps);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    const std::string name = "images/" + image_name(stamps[i]);
    result.images.want(frames[i], camera, name);
    result.posed.images.push_back(
        {.file = folder / name, .world_T_cam = poses[i]->world_T_imu * imu_T_cam});
  }
  return result;
}

}  // namespace chasles
