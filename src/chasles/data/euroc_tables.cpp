#include <string>

#include <fmt/format.h>

#include <chasles/data/csv.hpp>
#include <chasles/data/euroc_tables.hpp>
#include <chasles/data/gzip.hpp>
#include <chasles/data/imu_range.hpp>
#include <chasles/data/inertial_tables.hpp>
#include <chasles/data/kalibr.hpp>
#include <chasles/data/lens.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

using Names = std::vector<std::string>;

// The real part of a quaternion comes first, and the gyroscope bias before the accelerometer bias.
// Other orders would be read without an error, so the names are checked against these.
const std::vector<Names> kStateNames{
    {"timestamp", "p_RS_R_x", "p_RS_R_y", "p_RS_R_z", "q_RS_w", "q_RS_x", "q_RS_y", "q_RS_z",
     "v_RS_R_x", "v_RS_R_y", "v_RS_R_z", "b_w_RS_S_x", "b_w_RS_S_y", "b_w_RS_S_z", "b_a_RS_S_x",
     "b_a_RS_S_y", "b_a_RS_S_z"},
    {"time", "px", "py", "pz", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "bwx", "bwy", "bwz", "bax",
     "bay", "baz"}};

YamlMap read_sensor(const std::filesystem::path& file, const std::string& type, Names needed) {
  needed.insert(needed.begin(), {"sensor_type", "T_BS"});
  const YamlMap map = YamlMap::read(file, {.known = {}, .needed = needed});
  if (map.text("sensor_type") == type) return map;
  throw InputError(fmt::format("{}: is '{}', expected '{}'", map.where("sensor_type"),
                               map.text("sensor_type"), type));
}

}  // namespace

bool begins_euroc_imu(std::string_view bytes) {
  return bytes.starts_with("#timestamp [ns],w_RS_S_x") || bytes.starts_with("#ts,wx,wy,wz,ax");
}

void read_euroc_states(const std::filesystem::path& file, Recording& recording) {
  CsvReader csv(file.string(), read_plain_or_gzip(file), kStateNames);
  while (csv.next()) {
    const Time time = csv.time(0);
    if (!recording.truth.empty()) check_rises(csv.where(0), recording.truth.back().time, time);
    const Eigen::Vector4d xyzw(csv.finite(5), csv.finite(6), csv.finite(7), csv.finite(4));
    recording.truth.push_back(
        {.time = time, .pose = {checked_quaternion(csv.where(), xyzw), vector_at(csv, 1)}});
    recording.true_motion.push_back({.time = time,
                                     .v_world = vector_at(csv, 8),
                                     .accelerometer_bias = vector_at(csv, 14),
                                     .gyroscope_bias = vector_at(csv, 11)});
  }
}

EurocCamera read_euroc_camera(const std::filesystem::path& file) {
  const YamlMap map =
      read_sensor(file, "camera", {"resolution", "camera_model", "intrinsics", "distortion_model"});
  EurocCamera result{.camera = read_pinhole(map, {.distortion_model = "distortion_model",
                                                  .coefficients = "distortion_coefficients"}),
                     .time_offset = read_time_offset(map)};
  result.camera.cam_T_imu = map.motion("T_BS").inverse();
  return result;
}

Camera read_euroc_camera_of_tracks(const std::filesystem::path& file) {
  const EurocCamera read = read_euroc_camera(file);
  if (read.time_offset == Time::zero()) return read.camera;
  throw InputError(
      fmt::format("{}: key 'timeshift_cam_imu' is {} s, expected it for images only: "
                  "the times of tracks are by the IMU's clock",
                  file.string(), to_seconds(read.time_offset)));
}

ImuNoise read_euroc_imu_noise(const std::filesystem::path& file) {
  const Names keys{"accelerometer_noise_density", "accelerometer_random_walk",
                   "gyroscope_noise_density", "gyroscope_random_walk"};
  const YamlMap map = read_sensor(file, "imu", keys);
  const SE3 T = map.motion("T_BS");
  if (!T.R.isIdentity(1e-12) || !T.p.isZero(1e-12)) {
    throw InputError(map.where("T_BS") +
                     ": is not the identity, expected the IMU's frame as that of the body");
  }
  return {.accelerometer_noise_density = map.not_negative(keys[0]),
          .accelerometer_random_walk = map.not_negative(keys[1]),
          .gyroscope_noise_density = map.not_negative(keys[2]),
          .gyroscope_random_walk = map.not_negative(keys[3])};
}

ImuRange read_euroc_imu_range(const std::filesystem::path& file) {
  return read_imu_range(read_sensor(file, "imu", {}));
}

}  // namespace chasles
