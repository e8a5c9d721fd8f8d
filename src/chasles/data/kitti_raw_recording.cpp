#include <array>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/folder_names.hpp>
#include <chasles/data/image_files.hpp>
#include <chasles/data/image_recording.hpp>
#include <chasles/data/kitti_oxts.hpp>
#include <chasles/data/lens.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/data/time_order.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// "KEY: number number …" lines.
class KittiCalibration {
 public:
  explicit KittiCalibration(const fs::path& file) : file_(file.string()) {
    const std::string bytes = read_file(file);
    std::string_view rest = bytes;
    while (!rest.empty()) {
      const std::string_view line = take_line(rest);
      const std::size_t colon = line.find(':');
      if (colon == std::string_view::npos) continue;
      rows_[std::string(trimmed(line.substr(0, colon)))] = std::string(line.substr(colon + 1));
    }
  }
  std::string where(const std::string& key) const { return file_ + ": key '" + key + "'"; }
  Eigen::VectorXd numbers(const std::string& key, std::size_t size) const {
    const auto row = rows_.find(key);
    if (row == rows_.end()) throw InputError(where(key) + ": is missing");
    const auto words = split_words(row->second);
    if (words.size() != size) {
      throw InputError(
          fmt::format("{}: holds {} numbers, expected {}", where(key), words.size(), size));
    }
    Eigen::VectorXd values(static_cast<Eigen::Index>(size));
    for (std::size_t i = 0; i < size; ++i) {
      values[static_cast<Eigen::Index>(i)] = parse_finite(where(key), words[i]);
    }
    return values;
  }
  Eigen::Matrix3d rotation(const std::string& key) const {
    return checked_rotation(where(key),
                            Eigen::Matrix3d(numbers(key, 9).reshaped<Eigen::RowMajor>(3, 3)));
  }
  SE3 motion() const { return {rotation("R"), numbers("T", 3)}; }

 private:
  std::string file_;
  std::map<std::string, std::string> rows_;
};

// The rectified camera `number` (0 to 3): P = K [I | t], after R_rect_00.
Camera read_camera(const KittiCalibration& cameras, int number, const SE3& cam0_T_imu) {
  const std::string key = fmt::format("P_rect_{:02}", number);
  const Eigen::VectorXd P = cameras.numbers(key, 12);
  const std::string size_key = fmt::format("S_rect_{:02}", number);
  const Eigen::VectorXd size = cameras.numbers(size_key, 2);
  Camera camera{.width = checked_pixels(cameras.where(size_key), size[0]),
                .height = checked_pixels(cameras.where(size_key), size[1]),
                .fx = checked_positive(cameras.where(key), P[0]),
                .fy = checked_positive(cameras.where(key), P[5]),
                .cx = P[2],
                .cy = P[6],
                .distortion = Distortion::kNone,
                .coefficients = Eigen::Vector4d::Zero(),
                .cam_T_imu = {}};
  const Eigen::Vector3d t((P[3] - camera.cx * P[11]) / camera.fx,
                          (P[7] - camera.cy * P[11]) / camera.fy, P[11]);
  const SE3 rectified_T_cam0{cameras.rotation("R_rect_00"), t};
  camera.cam_T_imu = rectified_T_cam0 * cam0_T_imu;
  return camera;
}

CameraFiles list_kitti_images(const fs::path& camera) {
  CameraFiles files{.folder = camera / "data", .images = {}};
  for (const Time time : read_kitti_times(camera / "timestamps.txt")) {
    files.images.push_back({.time = time, .file = fmt::format("{:010}.png", files.images.size())});
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
  bring_into_order(recording.truth, "poses of the truth", recording.remarks);
}

}  // namespace

bool is_kitti_raw_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / "oxts", ignored) &&
         (fs::is_directory(folder / "image_00", ignored) ||
          fs::is_directory(folder / "image_02", ignored));
}

Recording read_kitti_raw_recording(const fs::path& folder) {
  if (folder_name(folder).ends_with("_extract")) {
    throw InputError(fmt::format(
        "{}: its images are not rectified, and KITTI's lens model has five coefficients, of which "
        "four are known here: give {}, the samples are taken from here",
        folder.string(), sibling(folder, "_extract", "_sync").filename().string()));
  }
  const fs::path day = folder / "..";
  Recording recording;
  recording.name = folder_name(folder);
  const SE3 cam0_T_imu = KittiCalibration(day / "calib_velo_to_cam.txt").motion() *
                         KittiCalibration(day / "calib_imu_to_velo.txt").motion();
  const KittiCalibration calibration(day / "calib_cam_to_cam.txt");
  std::vector<CameraFiles> images;
  for (const int number : cameras_in(folder)) {
    recording.cameras.push_back(read_camera(calibration, number, cam0_T_imu));
    images.push_back(list_kitti_images(folder / fmt::format("image_{:02}", number)));
  }
  read_oxts_samples(folder, recording);
  read_oxts_truth(folder, recording);
  recording.images =
      open_image_files(std::move(images), recording.cameras, kSameInstant, recording.remarks);
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
