#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/image_names.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The project's own calibration, or that of another program.
KalibrCalibration take_calibration(const fs::path& folder, std::size_t cameras,
                                   Recording& recording) {
  recording.name = folder_name(folder);
  if (fs::exists(folder / "calibration.yaml")) {
    return take_own_calibration(folder / "calibration.yaml", cameras, recording);
  }
  const auto rig = find_calibration({folder}, cameras);
  if (!rig) {
    throw InputError(fmt::format(
        "{}: there is no calibration.yaml and no camchain-imucam.yaml, expected the cameras' "
        "calibration in the folder of the recording: these, or the files of OpenVINS, VINS-Fusion, "
        "ORB-SLAM3 or Basalt{}",
        folder.string(), insufficient_calibration({folder})));
  }
  take_kalibr(*rig, recording);
  return *rig;
}

// images/, or the recording's folder itself as kalibr_bagextractor makes it.
fs::path images_of(const fs::path& folder) {
  return fs::exists(folder / "images") ? folder / "images" : folder;
}

// The folder of a camera's images: cam0 or, as KITTI names it, image_0; a single camera's may be
// `images` itself.
fs::path camera_folder(const fs::path& images, std::size_t c, std::size_t cameras) {
  const fs::path own = images / fmt::format("cam{}", c);
  if (fs::exists(own)) return own;
  const fs::path kitti = images / fmt::format("image_{}", c);
  if (fs::exists(kitti)) return kitti;
  return cameras == 1 && images.filename() == "images" && !images_in(images).empty() ? images : own;
}

// The list that names a camera's images from the folder of the recording, as UZH-FPV has it.
std::optional<fs::path> list_of_camera(const fs::path& folder, std::size_t c) {
  const std::vector<const char*> names = c == 0   ? std::vector{"left_images.txt", "images.txt"}
                                         : c == 1 ? std::vector{"right_images.txt"}
                                                  : std::vector<const char*>{};
  for (const char* name : names) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return std::nullopt;
}

std::vector<std::optional<CameraFiles>> list_images(const fs::path& folder, Recording& recording) {
  const fs::path images = images_of(folder);
  const std::size_t cameras = recording.cameras.size();
  std::vector<std::optional<CameraFiles>> files;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::string name = fmt::format("cam{}", c);
    const fs::path place = camera_folder(images, c, cameras);
    const auto list = fs::exists(place) ? std::nullopt : list_of_camera(folder, c);
    files.push_back(
        list ? read_image_list(*list, {.images = folder, .name = name}, recording.remarks)
             : list_camera_images({.images = place,
                                   .name = name,
                                   .shared = {images, folder, camera_folder(images, 0, cameras)}},
                                  recording.remarks));
  }
  fit_units(files, recording.imu, recording.remarks);
  return files;
}

bool has_imu_table(const fs::path& folder) {
  try {
    std::vector<std::string> ignored;
    return find_imu_table(folder, ignored).has_value();
  } catch (const InputError&) {  // several
    return true;
  }
}

// One table, or those of accelerometer and gyroscope apart.
void read_samples(const fs::path& folder, Recording& recording) {
  const auto found = find_imu_table(folder, recording.remarks);
  const SensorTables apart = find_sensor_tables(folder);
  if (!found && (apart.accelerometer || apart.gyroscope)) {
    return read_sensor_tables(apart, folder, recording);
  }
  const fs::path table = found.value_or(folder / "imu.csv");
  recording.imu = read_imu_table(table, recording.remarks);
  tidy_samples(table, recording);
  remark_on_open_end(table, recording.remarks);
}

}  // namespace

bool is_image_folder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder / "images", ignored)) return !fs::exists(folder / "frames.csv", ignored);
  const bool images = fs::is_directory(folder / "cam0", ignored) ||
                      fs::is_directory(folder / "image_0", ignored) || list_of_camera(folder, 0);
  return images && (has_imu_table(folder) || has_sensor_tables(folder));
}

Recording read_image_folder_recording(const fs::path& folder, std::size_t cameras) {
  Recording recording;
  const KalibrCalibration rig = take_calibration(folder, cameras, recording);
  const fs::path images = images_of(folder);
  if (cameras == kAllCameras) remark_on_further_camera(images, recording);
  read_samples(folder, recording);
  take_noise_of_samples(rig, recording);
  if (rig.imu_intrinsics) correct_samples(*rig.imu_intrinsics, recording);
  std::vector<std::optional<CameraFiles>> files = list_images(folder, recording);
  for (std::size_t c = 0; c < files.size(); ++c) {
    remark_on_open_end(images / fmt::format("cam{}", c) / "times.csv", recording.remarks);
  }
  open_cameras(std::move(files), rig.time_offsets, images / "cam0", recording);
  const fs::path truth = folder / "truth.tum";
  if (fs::exists(truth)) {
    read_truth_of_recording(truth, recording);
  } else if (fs::exists(folder / "groundtruth.txt")) {
    recording.remarks.push_back(
        "groundtruth.txt is not read: --truth takes it, if it is the trajectory of the IMU");
  }
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
