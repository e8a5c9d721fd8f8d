#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/image_names.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>
#include <chasles/recording/uncalibrated.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Where the parts of the recording are.
struct Parts {
  fs::path cameras;  // above cam0
  fs::path imu;      // the folder of its table
  bool is_euroc = false;
};

Parts parts_of(const fs::path& folder) {
  std::error_code ignored;
  if (is_euroc_asl_folder(folder)) {
    const fs::path sensors = fs::is_directory(folder / "mav0", ignored) ? folder / "mav0" : folder;
    return {.cameras = sensors, .imu = sensors / "imu0", .is_euroc = true};
  }
  const bool apart = fs::is_directory(folder / "images", ignored);
  return {.cameras = apart ? folder / "images" : folder, .imu = folder};
}

fs::path images_of_camera(const Parts& parts, std::size_t c) {
  const fs::path camera = parts.cameras / fmt::format("cam{}", c);
  std::error_code ignored;
  return fs::is_directory(camera / "data", ignored) ? camera / "data" : camera;
}

std::optional<fs::path> first_image(const fs::path& images) {
  std::error_code ignored;
  if (!fs::is_directory(images, ignored)) return std::nullopt;
  const std::vector<NumberedImage> found = images_in(images);
  return found.empty() ? std::nullopt : std::optional(images / found.front().file);
}

std::optional<fs::path> table_of(const Parts& parts) {
  std::error_code ignored;
  const fs::path euroc = parts.imu / "data.csv";
  if (parts.is_euroc && fs::exists(euroc, ignored)) return euroc;
  if (parts.is_euroc || !fs::is_directory(parts.imu, ignored)) return std::nullopt;
  std::vector<std::string> remarks;
  return find_imu_table(parts.imu, remarks);
}

bool has_calibration(const fs::path& folder, const Parts& parts) {
  std::error_code ignored;
  if (fs::exists(folder / "calibration.yaml", ignored) ||
      fs::exists(parts.cameras / "cam0" / "sensor.yaml", ignored)) {
    return true;
  }
  const fs::path beside = folder_name(folder) == "mav0" ? folder / ".." : folder;
  const std::vector<fs::path> places = {beside, beside / "dso", parts.cameras};
  return find_calibration(places) || !insufficient_calibration(places).empty();
}

// Of several tables the reader says so.
bool has_samples(const Parts& parts) {
  try {
    return table_of(parts) || has_sensor_tables(parts.imu);
  } catch (const InputError&) {
    return true;
  }
}

std::optional<CameraFiles> list_images_of(const Parts& parts, std::size_t c,
                                          std::vector<std::string>& remarks) {
  const std::string name = fmt::format("cam{}", c);
  const CameraPlace place{.images = images_of_camera(parts, c),
                          .name = name,
                          .shared = {parts.cameras, images_of_camera(parts, 0)}};
  const fs::path table = parts.cameras / name / "data.csv";
  std::error_code ignored;
  return fs::exists(table, ignored) ? read_image_list(table, place, remarks)
                                    : list_camera_images(place, remarks);
}

void read_samples_of(const Parts& parts, Recording& recording) {
  const std::optional<fs::path> table = table_of(parts);
  if (!table) return read_sensor_tables(find_sensor_tables(parts.imu), parts.imu, recording);
  recording.imu = read_imu_table(*table, recording.remarks);
  tidy_samples(*table, recording);
}

void take_noise(const fs::path& folder, const Parts& parts, Recording& recording) {
  const fs::path euroc = parts.imu / "sensor.yaml";
  if (parts.is_euroc && fs::exists(euroc)) {
    recording.imu_noise = read_euroc_imu_noise(euroc);
    recording.imu_range = read_euroc_imu_range(euroc);
  } else if (const auto file = find_kalibr_imu(folder)) {
    const KalibrCalibration imu = read_kalibr_imu(*file);
    recording.imu_noise = imu.imu_noise;
    recording.imu_range = imu.imu_range;
  }
}

}  // namespace

bool is_uncalibrated(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return false;
  const Parts parts = parts_of(folder);
  const bool has_times = fs::exists(parts.cameras / "cam0" / "data.csv", ignored);
  if (!first_image(images_of_camera(parts, 0)) || (!has_samples(parts) && !has_times)) return false;
  try {
    return !has_calibration(folder, parts);
  } catch (const InputError&) {  // its reader says what is wrong with it
    return false;
  }
}

Recording read_uncalibrated(const fs::path& folder) {
  Recording recording;
  recording.name = folder_name(folder_name(folder) == "mav0" ? folder / ".." : folder);
  const Parts parts = parts_of(folder);
  std::vector<std::optional<CameraFiles>> files;
  while (const auto image = first_image(images_of_camera(parts, files.size()))) {
    const ImageSize size = stated_size(read_file(*image), image->string());
    recording.cameras.push_back({.width = size.width, .height = size.height, .cam_T_imu = {}});
    files.push_back(list_images_of(parts, files.size(), recording.remarks));
  }
  if (has_samples(parts)) read_samples_of(parts, recording);
  take_noise(folder, parts, recording);
  fit_units(files, recording.imu, recording.remarks);
  open_cameras(std::move(files), {}, images_of_camera(parts, 0), recording);
  if (!recording.imu.empty()) remark_on_coverage(recording);
  return recording;
}

std::optional<fs::path> imu_table_of(const fs::path& folder) { return table_of(parts_of(folder)); }

}  // namespace chasles
