#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

constexpr double kLargestOffset = 4e9;  // [s]: from the clock since the start to that since 1970

// The extrinsics of a camera, by the key that names the direction. `alone`: without them, the first
// camera takes the place of the IMU.
SE3 cam_T_imu_of(const YamlMap& map, const std::vector<Camera>& before, bool alone) {
  if (map.has("T_cam_imu") && map.has("T_imu_cam")) {
    throw InputError(map.where("T_imu_cam") + ": is there beside T_cam_imu, expected one of them");
  }
  if (map.has("T_cam_imu")) return map.motion("T_cam_imu");
  if (map.has("T_imu_cam")) return map.motion("T_imu_cam").inverse();
  if (map.has("T_cn_cnm1") && !before.empty()) {
    return map.motion("T_cn_cnm1") * before.back().cam_T_imu;
  }
  if (alone && before.empty()) return {};
  throw InputError(
      fmt::format("{}: is missing, and so is T_imu_cam: expected where the camera is against the "
                  "IMU (a camchain.yaml without the IMU does not have it: take the "
                  "camchain-imucam.yaml of kalibr_calibrate_imu_camera)",
                  map.where("T_cam_imu")));
}

void read_camera(const YamlMap& map, bool alone, KalibrCalibration& calibration) {
  Camera camera = read_kalibr_lens(
      map, {.distortion_model = "distortion_model", .coefficients = "distortion_coeffs"});
  camera.cam_T_imu = cam_T_imu_of(map, calibration.cameras, alone);
  camera.shutter = read_shutter(map);
  calibration.cameras.push_back(camera);
  calibration.camera_topics.push_back(map.has("rostopic") ? map.text("rostopic") : "");
  calibration.time_offsets.push_back(read_time_offset(map));
}

void check_imu_frame(const YamlMap& map) {
  if (map.has("T_i_b") &&
      !(map.motion("T_i_b").R.isIdentity(1e-6) && map.motion("T_i_b").p.isZero(1e-6))) {
    throw InputError(map.where("T_i_b") +
                     ": is not the identity, expected the IMU's frame as that of the body");
  }
  if (map.has("time_offset") && map.number("time_offset") != 0) {
    throw InputError(fmt::format(
        "{}: is {}, expected 0: the IMU's clock as that of the body. State the offset of the "
        "cameras against it as timeshift_cam_imu in the camera chain, or shift the stamps of the "
        "samples",
        map.where("time_offset"), map.number("time_offset")));
  }
}

void read_imu_of(const YamlMap& map, KalibrCalibration& calibration) {
  calibration.imu_noise = {
      .accelerometer_noise_density = map.not_negative("accelerometer_noise_density"),
      .accelerometer_random_walk = map.not_negative("accelerometer_random_walk"),
      .gyroscope_noise_density = map.not_negative("gyroscope_noise_density"),
      .gyroscope_random_walk = map.not_negative("gyroscope_random_walk")};
  calibration.imu_range = read_imu_range(map);
  calibration.imu_intrinsics = read_imu_intrinsics(map, calibration.remarks);
  if (map.has("rostopic")) calibration.imu_topic = map.text("rostopic");
  if (map.has("update_rate")) calibration.imu_rate = map.number("update_rate");
  check_imu_frame(map);
}

void read_imu_file(const std::filesystem::path& file, KalibrCalibration& calibration) {
  const YamlMap imu = YamlMap::read(file, {});
  read_imu_of(imu.has("imu0") ? imu.map("imu0", {}) : imu, calibration);
}

void read_chain_file(const std::filesystem::path& file, std::size_t cameras, bool alone,
                     KalibrCalibration& calibration) {
  const YamlMap::Keys keys{
      .known = {}, .needed = {"camera_model", "intrinsics", "distortion_model", "resolution"}};
  const YamlMap chain = YamlMap::read(file, {.known = {}, .needed = {"cam0"}});
  for (std::size_t c = 0; c < cameras && chain.has(fmt::format("cam{}", c)); ++c) {
    read_camera(chain.map(fmt::format("cam{}", c), keys), alone, calibration);
  }
}

}  // namespace

Time read_time_offset(const YamlMap& map) {
  const std::string key = "timeshift_cam_imu";
  if (!map.has(key)) return Time::zero();
  const double seconds = map.number(key);
  if (std::abs(seconds) < kLargestOffset) return from_seconds(seconds);
  throw InputError(fmt::format("{}: is {}, expected seconds", map.where(key), seconds));
}

void remark_on_time_offsets(const std::vector<Time>& offsets, std::vector<std::string>& remarks) {
  for (std::size_t c = 0; c < offsets.size(); ++c) {
    const double ms = 1e3 * to_seconds(offsets[c]);
    if (offsets[c] == Time::zero()) continue;
    remarks.push_back(fmt::format(
        "the stamps of cam{} are {:.3f} ms {} against the IMU's (timeshift_cam_imu): corrected{}",
        c, std::abs(ms), ms < 0 ? "late" : "early",
        std::abs(ms) < 1000 ? "" : ". Is the offset in milliseconds? Seconds are expected"));
  }
}

KalibrCalibration read_kalibr_imu(const std::filesystem::path& file) {
  KalibrCalibration calibration;
  read_imu_file(file, calibration);
  return calibration;
}

KalibrCalibration read_kalibr_cameras(const std::filesystem::path& file) {
  KalibrCalibration calibration{.file = file};
  read_chain_file(file, kAllCameras, true, calibration);
  return calibration;
}

KalibrCalibration read_kalibr(const KalibrFiles& files, std::size_t cameras) {
  KalibrCalibration calibration{.file = files.cameras, .remarks = files.remarks};
  read_chain_file(files.cameras, cameras, false, calibration);
  remark_on_time_offsets(calibration.time_offsets, calibration.remarks);
  read_imu_file(files.imu, calibration);
  return calibration;
}

}  // namespace chasles
