#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/calibration.hpp>
#include <chasles/data/csv.hpp>
#include <chasles/data/folder_names.hpp>
#include <chasles/data/image_files.hpp>
#include <chasles/data/image_recording.hpp>
#include <chasles/data/imu_table.hpp>
#include <chasles/data/kalibr.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/sensor_tables.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::array kImuTables{"imu.csv", "imu0.csv"};

// The calibration of a folder, by one of its two kinds of files.
struct FolderRig {
  std::vector<Time> time_offsets;
  std::optional<ImuIntrinsics> imu_intrinsics;
};

FolderRig take_own_calibration(const fs::path& file, std::size_t cameras, Recording& recording) {
  FolderCalibration calibration = read_calibration(file);
  if (calibration.cameras.empty() || !calibration.imu_convention) {
    throw InputError(fmt::format(
        "{}: has no {}, expected both beside a folder of images", file.string(),
        calibration.cameras.empty() ? "cameras (a list)" : "imu_convention (and so no IMU)"));
  }
  cameras = std::min(cameras, calibration.cameras.size());
  calibration.cameras.resize(cameras);
  calibration.time_offsets.resize(cameras);
  recording.name = calibration.name;
  recording.cameras = calibration.cameras;
  recording.imu_convention = *calibration.imu_convention;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.single_pixel_sigma = calibration.single_pixel_sigma;
  recording.truth_level = calibration.truth_level;
  recording.remarks = calibration.remarks;
  remark_on_time_offsets(calibration.time_offsets, recording.remarks);
  return {.time_offsets = calibration.time_offsets, .imu_intrinsics = std::nullopt};
}

FolderRig take_calibration(const fs::path& folder, std::size_t cameras, Recording& recording) {
  recording.name = folder_name(folder);
  if (fs::exists(folder / "calibration.yaml")) {
    return take_own_calibration(folder / "calibration.yaml", cameras, recording);
  }
  const auto files = find_kalibr(folder);
  if (!files) {
    throw InputError(
        fmt::format("{}: there is no calibration.yaml and no camchain-imucam.yaml, expected the "
                    "cameras' calibration in the folder of the recording",
                    folder.string()));
  }
  const KalibrCalibration kalibr = read_kalibr(*files, cameras);
  take_kalibr(kalibr, recording);
  return {.time_offsets = kalibr.time_offsets, .imu_intrinsics = kalibr.imu_intrinsics};
}

// The column of the files' names.
std::size_t file_column(const CsvReader& csv) {
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    if (csv.columns()[i] == "file" || csv.columns()[i] == "filename") return i;
  }
  throw InputError(fmt::format("{}: has the columns {}, expected time_ns,file", csv.where(),
                               fmt::join(csv.headings(), ",")));
}

// The images of times.csv or, without it, those that are named by their times; none without a
// folder.
std::optional<CameraFiles> list_images(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return std::nullopt;
  const fs::path table = folder / "times.csv";
  if (!fs::exists(table)) {
    return CameraFiles{.folder = folder, .images = files_named_by_time(folder)};
  }
  CsvReader csv(table.string(), read_text(table));
  const std::size_t time = time_column(csv), file = file_column(csv);
  CameraFiles files{.folder = folder, .images = {}};
  while (csv.next()) {
    files.images.push_back({.time = time_at(csv, time), .file = std::string(csv.text(file))});
  }
  return files;
}

// images/, or the recording's folder itself as kalibr_bagextractor makes it.
fs::path images_of(const fs::path& folder) {
  return fs::exists(folder / "images") ? folder / "images" : folder;
}

fs::path imu_table_of(const fs::path& folder) {
  for (const char* name : kImuTables) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return folder / kImuTables.front();
}

// One table, or those of accelerometer and gyroscope apart.
void read_samples(const fs::path& folder, Recording& recording) {
  const fs::path table = imu_table_of(folder);
  const SensorTables apart = find_sensor_tables(folder);
  if (!fs::exists(table) && (apart.accelerometer || apart.gyroscope)) {
    return read_sensor_tables(apart, folder, recording);
  }
  recording.imu = read_imu_table(table);
  tidy_samples(table, recording);
  remark_on_open_end(table, recording.remarks);
}

}  // namespace

bool is_image_folder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::exists(folder / "images", ignored)) return !fs::exists(folder / "frames.csv", ignored);
  return fs::is_directory(folder / "cam0", ignored) &&
         (std::ranges::any_of(
              kImuTables, [&](const char* name) { return fs::exists(folder / name, ignored); }) ||
          has_sensor_tables(folder));
}

Recording read_image_folder_recording(const fs::path& folder, std::size_t cameras) {
  Recording recording;
  const FolderRig rig = take_calibration(folder, cameras, recording);
  const fs::path images = images_of(folder);
  if (cameras == kAllCameras) remark_on_further_camera(images, recording);
  read_samples(folder, recording);
  if (rig.imu_intrinsics) correct_samples(*rig.imu_intrinsics, recording);
  std::vector<std::optional<CameraFiles>> files;
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    files.push_back(list_images(images / fmt::format("cam{}", c)));
  }
  for (std::size_t c = 0; c < files.size(); ++c) {
    remark_on_open_end(images / fmt::format("cam{}", c) / "times.csv", recording.remarks);
  }
  open_cameras(std::move(files), rig.time_offsets, images / "cam0", recording);
  const fs::path truth = folder / "truth.tum";
  if (fs::exists(truth)) recording.truth = read_tum(truth, recording.remarks);
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
