#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/kitti_calibration.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/kitti_oxts.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/time_order.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The rectified camera `number` (0 to 3), after R_rect_00.
Camera read_camera(const KittiCalibration& cameras, int number, const SE3& cam0_T_imu) {
  const KittiProjection P = kitti_projection(cameras, fmt::format("P_rect_{:02}", number));
  const std::string size_key = fmt::format("S_rect_{:02}", number);
  const Eigen::VectorXd size = cameras.numbers(size_key, 2);
  const SE3 rectified_T_cam0{cameras.rotation("R_rect_00"), P.t};
  return {.width = checked_pixels(cameras.where(size_key), size[0]),
          .height = checked_pixels(cameras.where(size_key), size[1]),
          .fx = P.fx,
          .fy = P.fy,
          .cx = P.cx,
          .cy = P.cy,
          .cam_T_imu = rectified_T_cam0 * cam0_T_imu};
}

CameraFiles list_kitti_images(const fs::path& camera) {
  CameraFiles files{.folder = camera / "data", .images = {}};
  for (const KittiStamp& stamp : read_kitti_times(camera / "timestamps.txt")) {
    files.images.push_back({.time = stamp.time, .file = fmt::format("{:010}.png", stamp.index)});
  }
  return files;
}

// The grey pair, or the colour pair if there is no grey one; one camera if there is no pair.
std::vector<int> cameras_in(const fs::path& folder) {
  for (const auto& [left, right] : {std::pair{0, 1}, std::pair{2, 3}}) {
    const auto there = [&](int n) { return fs::exists(folder / fmt::format("image_{:02}", n)); };
    if (there(left)) return there(right) ? std::vector{left, right} : std::vector{left};
  }
  throw InputError(folder.string() + ": there is no image_00 and no image_02");
}

// 2011_09_26_drive_0001_extract beside 2011_09_26_drive_0001_sync.
fs::path sibling(const fs::path& folder, const std::string& from, const std::string& to) {
  std::string name = folder_name(folder);
  const std::size_t at = name.rfind(from);
  if (at == std::string::npos) return {};
  return folder / ".." / name.replace(at, from.size(), to);
}

void read_oxts_samples(const fs::path& synced, Recording& recording) {
  const fs::path unsynced = sibling(synced, "_sync", "_extract") / "oxts";
  const bool fast = fs::exists(unsynced / "timestamps.txt");
  std::vector<OxtsPacket> packets = read_oxts(fast ? unsynced : synced / "oxts");
  for (const OxtsPacket& packet : packets) recording.imu.push_back(packet.sample);
  tidy_samples(fast ? unsynced : synced / "oxts", recording);
  if (fast) return;
  recording.remarks.push_back(
      "the samples of the IMU are those of the frames, 10 Hz: for 100 Hz put the _extract folder "
      "beside the _sync folder");
}

void read_oxts_truth(const fs::path& synced, Recording& recording) {
  const std::vector<OxtsPacket> packets = read_oxts(synced / "oxts");
  recording.truth = oxts_trajectory(packets);
  recording.georeference = oxts_georeference(packets);
  bring_into_order(recording.truth, kTruePoses, recording.remarks);
}

}  // namespace

bool is_kitti_raw_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / "oxts", ignored) &&
         (fs::is_directory(folder / "image_00", ignored) ||
          fs::is_directory(folder / "image_02", ignored));
}

Recording read_kitti_raw_recording(const fs::path& folder, std::size_t cameras) {
  if (folder_name(folder).ends_with("_extract")) {
    throw InputError(fmt::format(
        "{}: its images are not rectified, and their calibration is not read: give {}, the samples "
        "are taken from here",
        folder.string(), sibling(folder, "_extract", "_sync").filename().string()));
  }
  const fs::path day = folder / "..";
  Recording recording;
  recording.name = folder_name(folder);
  const SE3 cam0_T_imu = KittiCalibration(day / "calib_velo_to_cam.txt").motion() *
                         KittiCalibration(day / "calib_imu_to_velo.txt").motion();
  const KittiCalibration calibration(day / "calib_cam_to_cam.txt");
  std::vector<std::optional<CameraFiles>> images;
  for (const int number : cameras_in(folder)) {
    if (images.size() == cameras) break;
    recording.cameras.push_back(read_camera(calibration, number, cam0_T_imu));
    images.push_back(list_kitti_images(folder / fmt::format("image_{:02}", number)));
  }
  read_oxts_samples(folder, recording);
  read_oxts_truth(folder, recording);
  open_cameras(std::move(images), {}, folder / "image_00", recording);
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
