#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/calibration/basalt_models.hpp>
#include <chasles/calibration/writing.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/utf8.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json basalt_lens_json(const Camera& camera, std::size_t index) {
  std::vector<double> stated = stated_coefficients(camera);
  const auto& models = basalt_models();
  const auto found = std::ranges::find(models, camera.distortion, &BasaltModel::model);
  if (found == models.end() || stated.size() > found->keys.size()) {
    no_such_lens(index, camera, "Basalt",
                 "none, radtan with at most 8 coefficients, equidistant, ds, eucm or fov");
  }
  stated.resize(found->keys.size());
  Json intrinsics{{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}};
  for (std::size_t i = 0; i < stated.size(); ++i) intrinsics[found->keys[i]] = stated[i];
  // Up to which radius Basalt takes the model; 0: as far as it goes.
  if (camera.distortion == Distortion::kRadtan) intrinsics["rpmax"] = 0.0;
  return {{"camera_type", found->name}, {"intrinsics", intrinsics}};
}

Json basalt_pose_json(const SE3& imu_T_cam) {
  const Eigen::Vector4d q = unit_quaternion(imu_T_cam.R);
  return {{"px", imu_T_cam.p.x()},
          {"py", imu_T_cam.p.y()},
          {"pz", imu_T_cam.p.z()},
          {"qx", q[0]},
          {"qy", q[1]},
          {"qz", q[2]},
          {"qw", q[3]}};
}

// f = (I + S) f_m - b: b, then S of the accelerometer by its lower triangle, of the gyroscope
// whole.
void add_basalt_intrinsics(const ImuIntrinsics& intrinsics, Json& value0) {
  std::vector<double> accelerometer(intrinsics.force_bias.begin(), intrinsics.force_bias.end());
  std::vector<double> gyroscope(intrinsics.rate_bias.begin(), intrinsics.rate_bias.end());
  const Eigen::Matrix3d force = intrinsics.force - Eigen::Matrix3d::Identity(),
                        rate = intrinsics.rate - Eigen::Matrix3d::Identity();
  for (const auto& [row, column] : kBasaltForcePlaces) accelerometer.push_back(force(row, column));
  gyroscope.insert(gyroscope.end(), rate.reshaped().begin(), rate.reshaped().end());
  value0["calib_accel_bias"] = accelerometer;
  value0["calib_gyro_bias"] = gyroscope;
}

bool fits_basalt(const ImuIntrinsics& intrinsics) {
  const Eigen::Matrix3d& force = intrinsics.force;
  return force(0, 1) == 0 && force(0, 2) == 0 && force(1, 2) == 0 &&
         intrinsics.rate_of_force.isZero(0);
}

// Basalt has one offset for all cameras.
double mean_time_offset(const CalibrationToWrite& calibration) {
  const std::vector<double>& all = calibration.time_offsets;
  if (all.empty()) return 0;
  return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
}

const char* const kBasaltRemark =
    "T_imu_cam maps coordinates of the camera to those of the IMU: p_imu = T_imu_cam * p_cam [m]. "
    "cam_time_offset_ns: clock of the IMU = clock of the camera + offset. Noise densities are in "
    "continuous time: accel_noise_std [m/s^2/sqrt(Hz)], gyro_noise_std [rad/s/sqrt(Hz)], "
    "accel_bias_std [m/s^3/sqrt(Hz)], gyro_bias_std [rad/s^2/sqrt(Hz)]. Pixels: the centre of the "
    "first one is (0, 0).";

Json basalt_value(const CalibrationToWrite& calibration) {
  Json value0{
      {"T_imu_cam", Json::array()}, {"intrinsics", Json::array()}, {"resolution", Json::array()}};
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const Camera& camera = calibration.cameras[c];
    value0["T_imu_cam"].push_back(basalt_pose_json(camera.cam_T_imu.inverse()));
    value0["intrinsics"].push_back(basalt_lens_json(camera, c));
    value0["resolution"].push_back({camera.width, camera.height});
  }
  const ImuIntrinsics stated = calibration.imu_intrinsics.value_or(ImuIntrinsics{});
  add_basalt_intrinsics(fits_basalt(stated) ? stated : ImuIntrinsics{}, value0);
  const ImuNoise noise = calibration.imu_noise.value_or(ImuNoise{});
  value0["imu_update_rate"] = calibration.imu_rate;
  value0["accel_noise_std"] = std::vector<double>(3, noise.accelerometer_noise_density);
  value0["gyro_noise_std"] = std::vector<double>(3, noise.gyroscope_noise_density);
  value0["accel_bias_std"] = std::vector<double>(3, noise.accelerometer_random_walk);
  value0["gyro_bias_std"] = std::vector<double>(3, noise.gyroscope_random_walk);
  value0["cam_time_offset_ns"] =
      static_cast<std::int64_t>(std::llround(1e9 * mean_time_offset(calibration)));
  value0["vignette"] = Json::array();
  return value0;
}

std::vector<std::string> left_out_of_basalt(const CalibrationToWrite& calibration) {
  std::vector<std::string> left_out =
      without_room(calibration, "Basalt's calibration.json", {.time_offsets = true});
  if (!calibration.imu_noise || !(calibration.imu_rate > 0)) {
    left_out.push_back(
        fmt::format("Basalt's calibration.json has zeros for {}, which {} not known: enter {}",
                    calibration.imu_noise      ? "imu_update_rate"
                    : calibration.imu_rate > 0 ? "the noise of an IMU"
                                               : "the noise and the rate of an IMU",
                    calibration.imu_noise || calibration.imu_rate > 0 ? "is" : "are",
                    calibration.imu_noise || calibration.imu_rate > 0 ? "it" : "them"));
  }
  if (calibration.imu_intrinsics && !fits_basalt(*calibration.imu_intrinsics)) {
    left_out.emplace_back(
        "Basalt's calibration.json has no intrinsics of the IMU: its accelerometer has a lower "
        "triangular matrix, and its gyroscope no g-sensitivity");
  }
  const auto [least, most] = std::ranges::minmax(
      calibration.time_offsets.empty() ? std::vector<double>{0} : calibration.time_offsets);
  if (most - least > 1e-9) {
    left_out.push_back(fmt::format(
        "Basalt's calibration.json has one time offset for all cameras: the mean of offsets that "
        "differ by up to {:.3g} ms",
        1e3 * (most - least)));
  }
  return left_out;
}

}  // namespace

// The remark follows value0, since cereal takes the first value of the file for it.
CalibrationFiles basalt_files(const CalibrationToWrite& calibration) {
  const Json json{
      {"value0", basalt_value(calibration)},
      {"remark", calibration.remark + (calibration.remark.empty() ? "" : " ") + kBasaltRemark}};
  return {.files = {{"basalt/calibration.json", json_text(json, 4) + "\n"}},
          .left_out = left_out_of_basalt(calibration)};
}

}  // namespace chasles
