#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/data/imu_range.hpp>
#include <chasles/data/kalibr.hpp>
#include <chasles/data/lens.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr double kShift = 1e-4;  // [s], worth a remark

bool is_camera_file(const std::string& name) {
  return name.find("camchain-imucam") != std::string::npos || name == "kalibr_imucam_chain.yaml";
}

bool is_imu_file(const std::string& name) {
  return name.starts_with("imu") || name == "kalibr_imu_chain.yaml";
}

// The one matching file; nothing if there is none.
std::optional<fs::path> only_file(const fs::path& folder, bool (*wanted)(const std::string&)) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& file = entry.path();
    if (file.extension() == ".yaml" && wanted(file.filename().string())) found.push_back(file);
  }
  if (found.empty()) return std::nullopt;
  std::sort(found.begin(), found.end());
  if (found.size() == 1) return found.front();
  throw InputError(fmt::format("{}: there are {} and {}, expected one of them: take the other away",
                               folder.string(), found[0].filename().string(),
                               found[1].filename().string()));
}

// The extrinsics of camera `index`, by the key that names the direction.
SE3 cam_T_imu_of(const YamlMap& map, const std::vector<Camera>& before) {
  if (map.has("T_cam_imu") && map.has("T_imu_cam")) {
    throw InputError(map.where("T_imu_cam") + ": is there beside T_cam_imu, expected one of them");
  }
  if (map.has("T_cam_imu")) return map.motion("T_cam_imu");
  if (map.has("T_imu_cam")) return map.motion("T_imu_cam").inverse();
  if (map.has("T_cn_cnm1") && !before.empty()) {
    return map.motion("T_cn_cnm1") * before.back().cam_T_imu;
  }
  throw InputError(
      fmt::format("{}: is missing, and so is T_imu_cam: expected where the camera is against the "
                  "IMU (a camchain.yaml without the IMU does not have it: take the "
                  "camchain-imucam.yaml of kalibr_calibrate_imu_camera)",
                  map.where("T_cam_imu")));
}

void read_camera(const YamlMap& map, const std::string& name, KalibrCalibration& calibration) {
  Camera camera = read_pinhole(
      map, {.distortion_model = "distortion_model", .coefficients = "distortion_coeffs"});
  camera.cam_T_imu = cam_T_imu_of(map, calibration.cameras);
  calibration.cameras.push_back(camera);
  calibration.camera_topics.push_back(map.has("rostopic") ? map.text("rostopic") : "");
  if (!map.has("timeshift_cam_imu")) return;
  const double shift = map.number("timeshift_cam_imu");
  if (std::abs(shift) < kShift) return;
  calibration.remarks.push_back(fmt::format(
      "Kalibr found the stamps of {} to be {:.1f} ms {} against the IMU's (timeshift_cam_imu): "
      "they are left as they are",
      name, 1e3 * std::abs(shift), shift < 0 ? "late" : "early"));
}

void read_imu_noise(const YamlMap& map, KalibrCalibration& calibration) {
  calibration.imu_noise = {
      .accelerometer_noise_density = map.not_negative("accelerometer_noise_density"),
      .accelerometer_random_walk = map.not_negative("accelerometer_random_walk"),
      .gyroscope_noise_density = map.not_negative("gyroscope_noise_density"),
      .gyroscope_random_walk = map.not_negative("gyroscope_random_walk")};
  calibration.imu_range = read_imu_range(map);
  if (map.has("rostopic")) calibration.imu_topic = map.text("rostopic");
  if (map.has("T_i_b") &&
      !(map.motion("T_i_b").R.isIdentity(1e-6) && map.motion("T_i_b").p.isZero(1e-6))) {
    throw InputError(map.where("T_i_b") +
                     ": is not the identity, expected the IMU's frame as that of the body");
  }
}

}  // namespace

std::optional<KalibrFiles> find_kalibr(const fs::path& folder) {
  const auto cameras = only_file(folder, is_camera_file);
  if (!cameras) return std::nullopt;
  const auto imu = only_file(folder, is_imu_file);
  if (imu) return KalibrFiles{.cameras = *cameras, .imu = *imu};
  throw InputError(
      fmt::format("{}: there is no imu.yaml beside {}, expected the noise of the IMU as Kalibr "
                  "takes it",
                  folder.string(), cameras->filename().string()));
}

KalibrCalibration read_kalibr(const KalibrFiles& files) {
  KalibrCalibration calibration;
  const YamlMap chain = YamlMap::read(files.cameras, {.known = {}, .needed = {"cam0"}});
  for (int c = 0; chain.has(fmt::format("cam{}", c)); ++c) {
    const std::string name = fmt::format("cam{}", c);
    read_camera(chain.map(name, {.known = {},
                                 .needed = {"camera_model", "intrinsics", "distortion_model",
                                            "resolution"}}),
                name, calibration);
  }
  const YamlMap imu = YamlMap::read(files.imu, {.known = {}, .needed = {}});
  read_imu_noise(imu.has("imu0") ? imu.map("imu0", {.known = {}, .needed = {}}) : imu, calibration);
  return calibration;
}

}  // namespace chasles
