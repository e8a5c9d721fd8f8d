#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/sensor_calibration.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// An IMU without a stated range measures no larger force [m/s^2].
constexpr double kMostForce = 64 * kStandardGravity;

const char* const kExpectedCalibration =
    "expected Kalibr's camera chain with imu.yaml beside it, the project's calibration.yaml, or a "
    "folder with them or with EuRoC's mav0 (docs/calibration-conventions.md)";

SensorCalibration of_chain(KalibrCalibration kalibr) {
  return {.cameras = std::move(kalibr.cameras),
          .time_offsets = std::move(kalibr.time_offsets),
          .camera_topics = std::move(kalibr.camera_topics),
          .imu_topic = std::move(kalibr.imu_topic),
          .imu_rate = kalibr.imu_rate,
          .imu_noise = kalibr.imu_noise,
          .imu_range = kalibr.imu_range,
          .imu_intrinsics = kalibr.imu_intrinsics,
          .remarks = std::move(kalibr.remarks)};
}

// The noise of a driver's samples needs their rate, which is not known before they come.
SensorCalibration of_foreign(const fs::path& path, KalibrCalibration rig, double imu_rate) {
  if (rig.noise_of_samples && imu_rate > 0) {
    rig.imu_noise = scaled(rig.imu_noise, 1 / std::sqrt(imu_rate));
  } else if (rig.noise_of_samples) {
    throw InputError(fmt::format(
        "{}: the noise of VINS (acc_n, gyr_n) is that of a sample, and the rate of the samples is "
        "not known here, {}; `chasles calibrate convert --imu-rate` makes such files of it",
        path.string(), kExpectedCalibration));
  }
  return of_chain(std::move(rig));
}

SensorCalibration of_own_file(const fs::path& file) {
  FolderCalibration own = read_calibration(file);
  if (own.cameras.empty() || !own.imu_noise) {
    throw InputError(
        fmt::format("{}: has {} cameras and {} noise of an IMU, expected both: `cameras`, and "
                    "accelerometer_noise_density and the three other keys of the noise",
                    file.string(), own.cameras.size(), own.imu_noise ? "the" : "no"));
  }
  const std::size_t cameras = own.cameras.size();
  return {.cameras = std::move(own.cameras),
          .time_offsets = std::move(own.time_offsets),
          .camera_topics = std::vector<std::string>(cameras),
          .imu_convention = own.imu_convention.value_or(ImuConvention::kInstant),
          .imu_noise = *own.imu_noise,
          .imu_range = own.imu_range,
          .single_pixel_sigma = own.single_pixel_sigma,
          .remarks = std::move(own.remarks)};
}

SensorCalibration of_euroc(const fs::path& sensors, std::size_t cameras) {
  SensorCalibration result{.exact_calibration = true};
  for (std::size_t c = 0; c < cameras; ++c) {
    const fs::path file = sensors / fmt::format("cam{}", c) / "sensor.yaml";
    if (c > 0 && !fs::exists(file)) break;
    const EurocCamera read = read_euroc_camera(file);
    result.exact_calibration = result.exact_calibration && read.exact;
    result.cameras.push_back(read.camera);
    result.time_offsets.push_back(read.time_offset);
    result.camera_topics.emplace_back();
  }
  const fs::path imu = sensors / "imu0" / "sensor.yaml";
  result.imu_noise = read_euroc_imu_noise(imu);
  result.imu_range = read_euroc_imu_range(imu);
  const YamlMap map = YamlMap::read(imu, {});
  if (map.has("rate_hz")) result.imu_rate = map.number("rate_hz");
  remark_on_time_offsets(result.time_offsets, result.remarks);
  return result;
}

std::optional<SensorCalibration> of_folder(const fs::path& folder, std::size_t cameras,
                                           double imu_rate) {
  for (const fs::path& sensors : {folder / "mav0", folder}) {
    if (fs::exists(sensors / "cam0" / "sensor.yaml")) return of_euroc(sensors, cameras);
  }
  if (fs::exists(folder / "calibration.yaml")) return of_own_file(folder / "calibration.yaml");
  if (const auto files = find_kalibr(folder)) return of_chain(read_kalibr(*files, cameras));
  if (const auto file = find_kalibr_imu(folder)) return of_chain(read_kalibr_imu(*file));
  if (auto rig = find_calibration({folder}, cameras)) {
    return of_foreign(folder, std::move(*rig), imu_rate);
  }
  return std::nullopt;
}

SensorCalibration of_file(const fs::path& file, std::size_t cameras, double imu_rate) {
  if (auto rig = read_foreign_calibration(file, cameras)) {
    return of_foreign(file, std::move(*rig), imu_rate);
  }
  const YamlMap map = YamlMap::read(file, {});
  if (map.has("format")) return of_own_file(file);
  if (map.has("imu0") || map.has("accelerometer_noise_density")) {
    return of_chain(read_kalibr_imu(file));
  }
  if (!map.has("cam0")) {
    throw InputError(fmt::format("{}: is no calibration, {}", file.string(), kExpectedCalibration));
  }
  const auto imu = find_kalibr_imu(file.has_parent_path() ? file.parent_path() : ".");
  if (!imu) {
    throw InputError(fmt::format(
        "{}: there is no imu.yaml beside it, expected the noise of the IMU as Kalibr takes it",
        file.string()));
  }
  return of_chain(read_kalibr({.cameras = file, .imu = *imu}, cameras));
}

}  // namespace

SensorCalibration read_sensor_calibration(const fs::path& path, std::size_t cameras) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    throw InputError(
        fmt::format("{}: there is no such file, {}", path.string(), kExpectedCalibration));
  }
  auto found = fs::is_directory(path, ignored) ? of_folder(path, cameras, 0)
                                               : std::optional(of_file(path, cameras, 0));
  if (!found) {
    throw InputError(
        fmt::format("{}: holds no calibration, {}", path.string(), kExpectedCalibration));
  }
  SensorCalibration result = std::move(*found);
  if (result.cameras.size() > cameras) {
    result.cameras.resize(cameras);
    result.time_offsets.resize(cameras);
    result.camera_topics.resize(cameras);
  }
  return result;
}

std::optional<SensorCalibration> find_sensor_calibration(const fs::path& path, double imu_rate) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return of_folder(path, kAllCameras, imu_rate);
  const std::string ending = lower_case(path.extension().string());
  const bool readable = ending == ".yaml" || ending == ".yml" ||
                        (ending == ".json" && read_foreign_calibration(path));
  if (!readable || !fs::is_regular_file(path, ignored)) return std::nullopt;
  return of_file(path, kAllCameras, imu_rate);
}

ImuSample corrected_sample(const SensorCalibration& calibration, const ImuSample& measured) {
  if (!calibration.imu_intrinsics) return measured;
  return corrected(*calibration.imu_intrinsics, calibration.imu_range, measured);
}

// The force changes a rate by no more than the range of the force allows.
ImuRange corrected_range(const SensorCalibration& calibration) {
  if (!calibration.imu_intrinsics) return calibration.imu_range;
  const ImuIntrinsics& intrinsics = *calibration.imu_intrinsics;
  const ImuRange& range = calibration.imu_range;
  const Eigen::Matrix3d of_measured = intrinsics.rate_of_force * intrinsics.force;
  const double largest = of_measured.cwiseAbs().rowwise().sum().maxCoeff();
  return corrected_range(intrinsics, range, largest * std::min(range.accelerometer, kMostForce));
}

}  // namespace chasles
