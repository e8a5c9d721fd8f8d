#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/imu_noise.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/inertial_tables.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/truth_table.hpp>

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

// Names of times, positions and quaternions, as for motion capture.
bool has_poses_alone(std::string_view table) {
  return std::ranges::count(take_line(table), ',') == 7;
}

}  // namespace

void read_poses_alone(const std::filesystem::path& file, Recording& recording) {
  read_truth_of_recording(file, recording);
  recording.remarks.push_back(fmt::format("the truth {} holds poses only: no velocities, no biases",
                                          file.filename().string()));
}

bool begins_euroc_imu(std::string_view bytes) {
  return bytes.starts_with("#timestamp [ns],w_RS_S_x") || bytes.starts_with("#ts,wx,wy,wz,ax");
}

void read_euroc_states(const std::filesystem::path& file, Recording& recording) {
  struct StateRow {
    Time time{};
    int line = 0;
    Eigen::Vector<double, 16> values;
  };
  std::string text = read_plain_or_gzip(file);
  if (has_poses_alone(text)) return read_poses_alone(file, recording);
  CsvReader csv(file.string(), std::move(text), kStateNames);
  std::vector<StateRow> rows;
  while (csv.next()) {
    StateRow& row = rows.emplace_back();
    row.time = csv.time(0);
    row.line = csv.line();
    for (Eigen::Index i = 0; i < row.values.size(); ++i) {
      row.values[i] = csv.number(static_cast<std::size_t>(i) + 1);
    }
  }
  remark_on_open_end(file, recording.remarks);
  if (rows.empty()) return;
  const auto known = [](const StateRow& row) { return row.values.allFinite(); };
  leave_out_unknown(file, known, kTruePoses, rows, recording.remarks);
  bring_into_order(rows, kTruePoses, recording.remarks);
  for (const StateRow& row : rows) {
    const Eigen::Vector4d xyzw(row.values[4], row.values[5], row.values[6], row.values[3]);
    const std::string where = fmt::format("{}:{}", file.string(), row.line);
    recording.truth.push_back(
        {.time = row.time, .pose = {checked_quaternion(where, xyzw), row.values.head<3>()}});
    recording.true_motion.push_back({.time = row.time,
                                     .v_world = row.values.segment<3>(7),
                                     .accelerometer_bias = row.values.segment<3>(13),
                                     .gyroscope_bias = row.values.segment<3>(10)});
  }
}

EurocCamera read_euroc_camera(const std::filesystem::path& file) {
  const YamlMap map =
      read_sensor(file, "camera", {"resolution", "camera_model", "intrinsics", "distortion_model"});
  EurocCamera result{.camera = read_kalibr_lens(map, {.distortion_model = "distortion_model",
                                                      .coefficients = "distortion_coefficients"}),
                     .time_offset = read_time_offset(map)};
  constexpr const char* kExact = "calibration_is_exact";
  result.exact =
      map.has(kExact) && map.flag(kExact, "the images are rendered with this calibration");
  result.camera.cam_T_imu = map.motion("T_BS").inverse();
  result.camera.shutter = read_shutter(map);
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
          .gyroscope_random_walk = map.not_negative(keys[3]),
          .exact = read_noise_is_exact(map)};
}

ImuRange read_euroc_imu_range(const std::filesystem::path& file) {
  return read_imu_range(read_sensor(file, "imu", {}));
}

}  // namespace chasles
