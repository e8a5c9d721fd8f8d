#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibration/basalt_models.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/json_numbers.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// T_imu_cam: camera to IMU.
SE3 basalt_cam_T_imu(const JsonPlace& pose) {
  const Eigen::Vector4d xyzw(pose.number("qx"), pose.number("qy"), pose.number("qz"),
                             pose.number("qw"));
  const Eigen::Vector3d p(pose.number("px"), pose.number("py"), pose.number("pz"));
  return SE3{checked_quaternion(pose.where(), xyzw), p}.inverse();
}

const BasaltModel& basalt_model(const JsonPlace& camera) {
  const std::string name = camera.text("camera_type");
  const auto found = std::ranges::find(basalt_models(), name, &BasaltModel::name);
  if (found != basalt_models().end()) return *found;
  std::vector<std::string_view> names;
  for (const BasaltModel& model : basalt_models()) names.push_back(model.name);
  throw InputError(fmt::format(
      "{}: camera_type is {}, a model that is not supported, expected one of {}: calibrate with "
      "one of these",
      camera.where(), name, fmt::join(names, ", ")));
}

Camera basalt_lens(const JsonPlace& camera, const JsonPlace& size) {
  const BasaltModel& model = basalt_model(camera);
  const JsonPlace lens = camera.at("intrinsics");
  Camera result{.width = checked_pixels(size.where(), size.number(0)),
                .height = checked_pixels(size.where(), size.number(1)),
                .fx = checked_positive(lens.where(), lens.number("fx")),
                .fy = checked_positive(lens.where(), lens.number("fy")),
                .cx = lens.number("cx"),
                .cy = lens.number("cy"),
                .cam_T_imu = {}};
  std::vector<double> coefficients;
  for (const char* key : model.keys) coefficients.push_back(lens.number(key));
  if (model.name == "ucm") coefficients.push_back(1);  // beta
  set_lens(lens.where(), model.model, without_padding(model.model, coefficients), result);
  return result;
}

// Basalt has one entry for each camera in all three lists.
void check_camera_counts(const JsonPlace& poses, const JsonPlace& lenses, const JsonPlace& sizes) {
  if (poses.size() == lenses.size() && lenses.size() == sizes.size()) return;
  throw InputError(fmt::format(
      "{}: has {} poses, but {} has {} lenses and {} {} sizes, expected one of each for each "
      "camera",
      poses.where(), poses.size(), lenses.where(), lenses.size(), sizes.where(), sizes.size()));
}

// The largest of three densities; old files have one number.
double basalt_density(const JsonPlace& value0, const char* key) {
  if (!value0.at(key).is_list()) return value0.number(key);
  const JsonPlace list = value0.at(key);
  return std::max({list.number(0), list.number(1), list.number(2)});
}

// f = (I + S) f_m - b, where S of the accelerometer is lower triangular, by columns.
std::optional<ImuIntrinsics> basalt_intrinsics(const JsonPlace& value0) {
  if (!value0.has("calib_accel_bias") && !value0.has("calib_gyro_bias")) return std::nullopt;
  ImuIntrinsics result;
  double largest = 0;
  const JsonPlace a = value0.at("calib_accel_bias"), g = value0.at("calib_gyro_bias");
  for (std::size_t i = 0; i < 3; ++i) {
    result.force_bias[static_cast<int>(i)] = a.number(i);
    result.rate_bias[static_cast<int>(i)] = g.number(i);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    result.force(kBasaltForcePlaces[i][0], kBasaltForcePlaces[i][1]) += a.number(3 + i);
  }
  for (std::size_t i = 0; i < 9; ++i) {
    result.rate(static_cast<int>(i % 3), static_cast<int>(i / 3)) += g.number(3 + i);
  }
  for (std::size_t i = 0; i < 9; ++i) largest = std::max(largest, std::abs(a.number(i)));
  for (std::size_t i = 0; i < 12; ++i) largest = std::max(largest, std::abs(g.number(i)));
  return largest == 0 ? std::nullopt : std::optional(result);
}

}  // namespace

KalibrCalibration read_basalt(const fs::path& file, std::size_t cameras) {
  const JsonFile json(file);
  const JsonPlace value0 = json.root().at("value0");
  const JsonPlace poses = value0.at("T_imu_cam"), lenses = value0.at("intrinsics"),
                  sizes = value0.at("resolution");
  KalibrCalibration result;
  check_camera_counts(poses, lenses, sizes);
  const std::size_t count = std::min(cameras, poses.size());
  const double offset = value0.has("cam_time_offset_ns") ? value0.number("cam_time_offset_ns") : 0;
  for (std::size_t c = 0; c < count; ++c) {
    Camera camera = basalt_lens(lenses.at(c), sizes.at(c));
    camera.cam_T_imu = basalt_cam_T_imu(poses.at(c));
    result.cameras.push_back(camera);
    result.time_offsets.push_back(from_seconds(1e-9 * offset));
    result.camera_topics.emplace_back();
  }
  if (result.cameras.empty()) {
    throw InputError(fmt::format("{}: T_imu_cam is empty, expected a camera", value0.where()));
  }
  result.imu_noise = {.accelerometer_noise_density = basalt_density(value0, "accel_noise_std"),
                      .accelerometer_random_walk = basalt_density(value0, "accel_bias_std"),
                      .gyroscope_noise_density = basalt_density(value0, "gyro_noise_std"),
                      .gyroscope_random_walk = basalt_density(value0, "gyro_bias_std")};
  result.imu_intrinsics = basalt_intrinsics(value0);
  if (value0.has("imu_update_rate")) result.imu_rate = value0.number("imu_update_rate");
  result.remarks.push_back(
      fmt::format("the calibration is that of {} (Basalt)", file.filename().string()));
  remark_on_time_offsets(result.time_offsets, result.remarks);
  return result;
}

}  // namespace chasles
