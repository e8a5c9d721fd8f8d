#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

const std::vector<Names> kImageNames{{"timestamp", "filename"}};

// The folder of the sensors: mav0 in the recording, or the recording itself.
fs::path sensors_of(const fs::path& folder) {
  return fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
}

// The folder of files that are not EuRoC's: beside mav0, also if the user named mav0 itself.
fs::path folder_of(const fs::path& folder) {
  return folder_name(folder) == "mav0" ? folder / ".." : folder;
}

std::string sequence_name(const fs::path& folder) { return folder_name(folder_of(folder)); }

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// The table begins as EuRoC's, with a comment.
bool begins_as_euroc(const fs::path& table) {
  std::string bytes = read_plain_or_gzip(table);
  remove_byte_order_mark(bytes);
  return bytes.starts_with('#');
}

// The images of data.csv or, without it, those that are named by their times; none without a folder
// of images.
std::optional<CameraFiles> list_asl_images(const fs::path& folder, const std::string& name,
                                           std::vector<std::string>& remarks) {
  const fs::path camera = sensors_of(folder) / name, table = camera / "data.csv";
  const CameraPlace place{.images = camera / "data",
                          .name = name,
                          .shared = {camera, sensors_of(folder), folder_of(folder)}};
  CameraFiles files{.folder = place.images, .images = {}};
  if (!is_folder(files.folder)) return std::nullopt;
  if (!fs::exists(table)) return list_camera_images(place, remarks);
  if (!begins_as_euroc(table)) return read_image_list(table, place, remarks);
  CsvReader csv(table.string(), read_plain_or_gzip(table), kImageNames);
  while (csv.next()) {
    files.images.push_back({.time = csv.time(0), .file = std::string(csv.text(1))});
  }
  if (!files.images.empty()) return files;
  throw InputError(table.string() + ": lists no image, expected rows `time,file`");
}

// Where Kalibr's files and those of others may be: beside mav0, in dso/ (TUM-VI) or in mav0.
std::vector<fs::path> calibration_places(const fs::path& folder) {
  return {folder_of(folder), folder_of(folder) / "dso", sensors_of(folder)};
}

std::optional<KalibrFiles> kalibr_of(const fs::path& folder) {
  for (const fs::path& place : calibration_places(folder)) {
    if (auto files = find_kalibr(place)) return files;
  }
  return std::nullopt;
}

KalibrCalibration take_sensor_files(const fs::path& sensors, std::size_t cameras,
                                    Recording& recording) {
  KalibrCalibration calibration;
  for (std::size_t c = 0; c < cameras; ++c) {
    const fs::path camera = sensors / fmt::format("cam{}", c);
    const bool is_there = is_folder(camera) && !fs::is_empty(camera);
    if (c > 0 && !is_there) break;
    const EurocCamera read = read_euroc_camera(camera / "sensor.yaml");
    recording.exact_calibration = read.exact && (c == 0 || recording.exact_calibration);
    recording.cameras.push_back(read.camera);
    calibration.time_offsets.push_back(read.time_offset);
  }
  remark_on_time_offsets(calibration.time_offsets, recording.remarks);
  const fs::path imu = sensors / "imu0" / "sensor.yaml";
  if (!fs::exists(imu)) {
    throw InputError(fmt::format(
        "{}: no such file, expected the IMU's noise: accelerometer_noise_density, "
        "accelerometer_random_walk, gyroscope_noise_density and gyroscope_random_walk, with "
        "sensor_type: imu and T_BS (docs/your-recording.md)",
        imu.string()));
  }
  recording.imu_noise = read_euroc_imu_noise(imu);
  recording.imu_range = read_euroc_imu_range(imu);
  return calibration;
}

void remark_on_unused_kalibr(const fs::path& folder, Recording& recording) {
  try {
    const auto files = kalibr_of(folder);
    if (!files) return;
    recording.remarks.push_back(
        fmt::format("the calibration is that of the sensor.yaml files, and {} is not read",
                    files->cameras.filename().string()));
  } catch (const InputError&) {  // what is not read need not be good
  }
}

// Kalibr's files serve where there is no sensor.yaml.
KalibrCalibration take_asl_calibration(const fs::path& folder, std::size_t cameras,
                                       Recording& recording) {
  const fs::path sensors = sensors_of(folder);
  const fs::path first = sensors / "cam0" / "sensor.yaml";
  if (fs::exists(first)) {
    remark_on_unused_kalibr(folder, recording);
    return take_sensor_files(sensors, cameras, recording);
  }
  const std::vector<fs::path> places = calibration_places(folder);
  const std::optional<KalibrCalibration> rig = find_calibration(places, cameras);
  if (!rig) {
    throw InputError(fmt::format(
        "{}: no such file, and there is no camchain-imucam.yaml of Kalibr beside mav0: expected "
        "one of them, or the files of OpenVINS, VINS-Fusion, ORB-SLAM3 or Basalt{}",
        first.string(), insufficient_calibration(places)));
  }
  take_kalibr(*rig, recording);
  if (!rig->file.empty()) {
    recording.remarks.push_back(fmt::format(
        "there is no sensor.yaml: the calibration is that of {}", rig->file.filename().string()));
  }
  return *rig;
}

// imu0/data.csv, or tables of accelerometer and gyroscope apart in imu0 or beside it.
void read_asl_samples(const fs::path& sensors, Recording& recording) {
  const fs::path table = sensors / "imu0" / "data.csv";
  for (const fs::path& place : {sensors / "imu0", sensors}) {
    if (fs::exists(table) || !has_sensor_tables(place)) continue;
    return read_sensor_tables(find_sensor_tables(place), place, recording);
  }
  recording.imu = read_imu_table(table, recording.remarks);
  tidy_samples(table, recording);
  remark_on_open_end(table, recording.remarks);
}

// The measurements of a motion capture system or of a total station.
void read_tracker_truth(const fs::path& sensors, Recording& recording) {
  for (const char* name : {"mocap0", "vicon0", "leica0"}) {
    const fs::path file = sensors / name / "data.csv";
    if (!fs::exists(file)) continue;
    recording.remarks.push_back(fmt::format("the truth is {}/data.csv", name));
    return read_truth_of_recording(file, recording);
  }
  recording.remarks.push_back(
      "no truth: there is neither state_groundtruth_estimate0/data.csv, mocap0/data.csv, "
      "vicon0/data.csv, leica0/data.csv nor truth.tum");
}

void read_asl_truth(const fs::path& folder, Recording& recording) {
  const fs::path states = sensors_of(folder) / "state_groundtruth_estimate0" / "data.csv";
  const fs::path poses = folder_of(folder) / "truth.tum";
  if (fs::exists(poses)) {  // not EuRoC's: placed there on purpose
    read_truth_of_recording(poses, recording);
  } else if (fs::exists(states)) {
    read_euroc_states(states, recording);
  } else {
    read_tracker_truth(sensors_of(folder), recording);
  }
}

}  // namespace

bool is_euroc_asl_folder(const fs::path& folder) {
  std::error_code ignored;
  const fs::path mav0 = folder / "mav0";
  return fs::is_directory(mav0, ignored) ||
         (fs::is_directory(folder / "cam0", ignored) && fs::is_directory(folder / "imu0", ignored));
}

Recording read_euroc_asl_recording(const fs::path& folder, std::size_t cameras) {
  const fs::path sensors = sensors_of(folder);
  Recording recording;
  recording.name = sequence_name(folder);
  const KalibrCalibration calibration = take_asl_calibration(folder, cameras, recording);
  if (cameras == kAllCameras) remark_on_further_camera(sensors, recording);
  std::vector<std::optional<CameraFiles>> images;
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    const std::string name = fmt::format("cam{}", c);
    images.push_back(list_asl_images(folder, name, recording.remarks));
    remark_on_open_end(sensors / name / "data.csv", recording.remarks);
  }
  read_asl_samples(sensors, recording);
  fit_units(images, recording.imu, recording.remarks);
  take_noise_of_samples(calibration, recording);
  if (calibration.imu_intrinsics) correct_samples(*calibration.imu_intrinsics, recording);
  open_cameras(std::move(images), calibration.time_offsets, sensors / "cam0" / "data", recording);
  read_asl_truth(folder, recording);
  recording.plan = read_plan_of(folder_of(folder));
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
