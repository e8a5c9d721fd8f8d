#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/calibration_to_write.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_calibration.hpp>
#include <chasles/recording/uncalibrated.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

std::vector<double> in_seconds(const std::vector<Time>& offsets) {
  std::vector<double> seconds;
  for (const Time offset : offsets) seconds.push_back(to_seconds(offset));
  return seconds;
}

// calibration.yaml of a folder, or the file itself, also of cameras without an IMU.
std::optional<fs::path> own_file_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    const bool euroc = fs::exists(path / "mav0") || fs::exists(path / "cam0" / "sensor.yaml");
    const fs::path own = path / "calibration.yaml";
    return !euroc && fs::exists(own) ? std::optional(own) : std::nullopt;
  }
  const std::string ending = lower_case(path.extension().string());
  if (ending != ".yaml" && ending != ".yml") return std::nullopt;
  return YamlMap::read(path, {}).has("format") ? std::optional(path) : std::nullopt;
}

CalibrationFound of_own(const fs::path& file) {
  FolderCalibration own = read_calibration(file);
  if (own.cameras.empty()) {
    throw InputError(fmt::format(
        "{}: has {}, expected the list `cameras`, with the sizes of their images", file.string(),
        own.rig ? "a rectified stereo pair, whose images have no size" : "no cameras"));
  }
  return {.calibration = {.name = own.name,
                          .cameras = std::move(own.cameras),
                          .time_offsets = in_seconds(own.time_offsets),
                          .has_imu = own.imu_convention || own.imu_noise,
                          .imu_convention = own.imu_convention.value_or(ImuConvention::kInstant),
                          .imu_noise = own.imu_noise,
                          .imu_range = own.imu_range},
          .remarks = std::move(own.remarks)};
}

CalibrationFound of_sensors(const fs::path& path, SensorCalibration sensors) {
  if (sensors.cameras.empty()) {
    throw InputError(
        fmt::format("{}: has an IMU alone, expected the calibration of cameras", path.string()));
  }
  return {.calibration = {.name = folder_name(path),
                          .cameras = std::move(sensors.cameras),
                          .time_offsets = in_seconds(sensors.time_offsets),
                          .has_imu = true,
                          .imu_convention = sensors.imu_convention,
                          .imu_noise = sensors.imu_noise,
                          .imu_range = sensors.imu_range,
                          .imu_rate = sensors.imu_rate,
                          .imu_intrinsics = sensors.imu_intrinsics,
                          .camera_topics = std::move(sensors.camera_topics),
                          .imu_topic = std::move(sensors.imu_topic)},
          .remarks = std::move(sensors.remarks)};
}

// Kalibr's camera chain without the IMU, or without the file of its noise beside it. `has_imu`:
// whether it knows where the IMU is.
std::optional<CalibrationFound> of_chain_alone(const fs::path& path) {
  const std::string ending = lower_case(path.extension().string());
  if (fs::is_directory(path) || (ending != ".yaml" && ending != ".yml")) return std::nullopt;
  const YamlMap map = YamlMap::read(path, {});
  if (!map.has("cam0")) return std::nullopt;
  const YamlMap first = map.map("cam0", {});
  const bool has_imu = first.has("T_cam_imu") || first.has("T_imu_cam");
  if (has_imu && find_kalibr_imu(fs::absolute(path).parent_path())) return std::nullopt;
  KalibrCalibration chain = read_kalibr_cameras(path);
  return CalibrationFound{.calibration = {.name = folder_name(path),
                                          .cameras = std::move(chain.cameras),
                                          .time_offsets = has_imu ? in_seconds(chain.time_offsets)
                                                                  : std::vector<double>{},
                                          .has_imu = has_imu,
                                          .camera_topics = std::move(chain.camera_topics)},
                          .remarks = std::move(chain.remarks)};
}

bool are_the_same(const std::vector<Camera>& a, const std::vector<Camera>& b) {
  return std::ranges::equal(a, b, [](const Camera& x, const Camera& y) {
    return x.fx == y.fx && x.cx == y.cx && x.cam_T_imu.R == y.cam_T_imu.R &&
           x.cam_T_imu.p == y.cam_T_imu.p;
  });
}

// What the reader of a recording has applied to its data: the offsets to the stamps, and the
// intrinsics to the samples of the IMU.
void add_applied(const fs::path& path, const Recording& recording,
                 CalibrationToWrite& calibration) {
  const fs::path folder = fs::is_directory(path) ? path : fs::absolute(path).parent_path();
  const auto rig = find_calibration({folder}, recording.cameras.size());
  if (!rig || !are_the_same(rig->cameras, recording.cameras)) return;
  calibration.time_offsets = in_seconds(rig->time_offsets);
  calibration.imu_intrinsics = rig->imu_intrinsics;
  calibration.imu_range = rig->imu_range;
  calibration.camera_topics = rig->camera_topics;
  calibration.imu_topic = rig->imu_topic;
}

// What a recording states, without what its reader has applied.
CalibrationFound to_write(const Recording& recording) {
  CalibrationFound found{.calibration = {.name = recording.name,
                                         .cameras = recording.cameras,
                                         .has_imu = !recording.imu.empty(),
                                         .imu_convention = recording.imu_convention,
                                         .imu_noise = recording.imu_noise,
                                         .imu_range = recording.imu_range},
                         .remarks = recording.remarks};
  const std::vector<ImuSample>& imu = recording.imu;
  if (imu.size() > 1) {
    found.calibration.imu_rate =
        static_cast<double>(imu.size() - 1) / to_seconds(imu.back().time - imu.front().time);
  }
  return found;
}

CalibrationFound of_recording(const fs::path& path) {
  const Recording recording = read_recording(path);
  if (recording.cameras.empty()) {
    throw InputError(fmt::format(
        "{}: is a recording {}, expected one of cameras with the sizes of their images",
        path.string(), recording.rig.fx > 0 ? "of a rectified stereo pair" : "without cameras"));
  }
  CalibrationFound found = to_write(recording);
  add_applied(path, recording, found.calibration);
  return found;
}

}  // namespace

CalibrationFound find_calibration_to_write(const fs::path& path, double imu_rate) {
  CalibrationFound found;
  if (const auto own = own_file_of(path)) {
    found = of_own(*own);
  } else if (auto chain = of_chain_alone(path)) {
    found = std::move(*chain);
  } else {
    auto sensors = find_sensor_calibration(path, imu_rate);
    // Beside a bag, the file of an IMU alone has no cameras: the bag has them.
    const bool whole = sensors && (!sensors->cameras.empty() || fs::is_regular_file(path));
    found = whole ? of_sensors(path, std::move(*sensors)) : of_recording(path);
  }
  if (imu_rate > 0) found.calibration.imu_rate = imu_rate;
  return found;
}

CalibrationFound find_calibration_to_replace(const fs::path& recording) {
  if (!is_uncalibrated(recording)) return find_calibration_to_write(recording);
  Recording found = read_uncalibrated(recording);
  found.cameras.clear();
  return to_write(found);
}

}  // namespace chasles
