#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/calibration.hpp>
#include <chasles/data/csv.hpp>
#include <chasles/data/folder_names.hpp>
#include <chasles/data/image_files.hpp>
#include <chasles/data/image_recording.hpp>
#include <chasles/data/inertial_tables.hpp>
#include <chasles/data/kalibr.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kTimeColumns{"time_ns", "file"};

void take_own_calibration(const fs::path& file, Recording& recording) {
  const FolderCalibration calibration = read_calibration(file);
  if (calibration.cameras.empty() || !calibration.imu_convention) {
    throw InputError(fmt::format(
        "{}: has no {}, expected both beside a folder of images", file.string(),
        calibration.cameras.empty() ? "cameras (a list)" : "imu_convention (and so no IMU)"));
  }
  recording.name = calibration.name;
  recording.cameras = calibration.cameras;
  recording.imu_convention = *calibration.imu_convention;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.single_pixel_sigma = calibration.single_pixel_sigma;
  recording.remarks = calibration.remarks;
}

void take_calibration(const fs::path& folder, Recording& recording) {
  recording.name = folder_name(folder);
  if (fs::exists(folder / "calibration.yaml")) {
    take_own_calibration(folder / "calibration.yaml", recording);
    return;
  }
  const auto files = find_kalibr(folder);
  if (!files) {
    throw InputError(
        fmt::format("{}: there is no calibration.yaml and no camchain-imucam.yaml, expected the "
                    "cameras' calibration beside images/",
                    folder.string()));
  }
  const KalibrCalibration kalibr = read_kalibr(*files);
  recording.cameras = kalibr.cameras;
  recording.imu_noise = kalibr.imu_noise;
  recording.imu_range = kalibr.imu_range;
  recording.remarks = kalibr.remarks;
}

CameraFiles list_images(const fs::path& folder) {
  const fs::path table = folder / "times.csv";
  if (!fs::exists(table)) return {.folder = folder, .images = files_named_by_time(folder)};
  CsvReader csv(table, kTimeColumns);
  CameraFiles files{.folder = folder, .images = {}};
  while (csv.next()) {
    files.images.push_back({.time = csv.time(0), .file = std::string(csv.text(1))});
  }
  return files;
}

// Checks that there are as many folders as calibrated cameras.
std::vector<CameraFiles> list_cameras(const fs::path& images, std::size_t cameras) {
  std::vector<CameraFiles> all;
  for (std::size_t c = 0; c < cameras; ++c) {
    all.push_back(list_images(images / fmt::format("cam{}", c)));
  }
  const fs::path next = images / fmt::format("cam{}", cameras);
  if (!fs::exists(next)) return all;
  throw InputError(fmt::format("{}: is there, but the calibration has {} camera{} only",
                               next.string(), cameras, cameras == 1 ? "" : "s"));
}

void read_folder_samples(const fs::path& file, Recording& recording) {
  CsvReader csv(file, kImuColumns);
  while (csv.next()) {
    recording.imu.push_back({.time = csv.time(0),
                             .specific_force_imu = vector_at(csv, 4),
                             .angular_rate_imu = vector_at(csv, 1)});
  }
  tidy_samples(file, recording);
}

}  // namespace

Recording read_image_folder_recording(const fs::path& folder) {
  Recording recording;
  take_calibration(folder, recording);
  read_folder_samples(folder / "imu.csv", recording);
  recording.images = open_image_files(list_cameras(folder / "images", recording.cameras.size()),
                                      recording.cameras, kSameInstant, recording.remarks);
  if (fs::exists(folder / "truth.tum")) recording.truth = read_tum(folder / "truth.tum");
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
