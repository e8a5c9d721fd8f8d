#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Whether there is a value of a lens.
bool has_any(const YamlMap& map, const std::string& prefix) {
  constexpr std::array kValues{"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2"};
  return std::ranges::any_of(kValues, [&](const char* name) { return map.has(prefix + name); });
}

// The keys of the first camera begin with Camera1. in new files, with Camera. in old ones.
std::string orb_prefix(const YamlMap& map, int number) {
  if (number == 1 && !has_any(map, "Camera1.")) return "Camera.";
  return fmt::format("Camera{}.", number);
}

// k1, k2, p1, p2, k3; zeros mean no distortion.
void set_opencv_lens(const std::array<double, 5>& k, Camera& camera) {
  camera.coefficients = LensCoefficients(without_padding(Distortion::kRadtan, k));
  if (camera.coefficients.is_zero()) camera.coefficients = {};
  camera.distortion = camera.coefficients.size() == 0 ? Distortion::kNone : Distortion::kRadtan;
}

std::string orb_model(const YamlMap& map) {
  return map.has("Camera.type") ? lower_case(map.text("Camera.type")) : "pinhole";
}

// New files may leave out all coefficients of a pinhole, and any file may leave out k3; ORB-SLAM3
// requires the others.
void set_orb_distortion(const YamlMap& map, const std::string& prefix, Camera& camera) {
  const auto value = [&](const char* name) { return map.number(prefix + name); };
  const std::string model = orb_model(map);
  if (model == "rectified") return;
  if (model == "kannalabrandt8") {
    camera.distortion = Distortion::kEquidistant;
    camera.coefficients = {value("k1"), value("k2"), value("k3"), value("k4")};
    return;
  }
  if (model != "pinhole") {
    throw InputError(fmt::format(
        "{}: is {}, a model that is not supported, expected PinHole, KannalaBrandt8 or Rectified",
        map.where("Camera.type"), map.text("Camera.type")));
  }
  const bool stated = std::ranges::any_of(std::array{"k1", "k2", "k3", "p1", "p2"},
                                          [&](const char* name) { return map.has(prefix + name); });
  if (!stated && prefix != "Camera.") return;
  set_opencv_lens({value("k1"), value("k2"), value("p1"), value("p2"),
                   map.has(prefix + "k3") ? value("k3") : 0},
                  camera);
}

Camera orb_lens(const YamlMap& map, int number) {
  const std::string prefix = orb_prefix(map, number);
  Camera camera{.width = checked_pixels(map.where("Camera.width"), map.number("Camera.width")),
                .height = checked_pixels(map.where("Camera.height"), map.number("Camera.height")),
                .fx = map.positive(prefix + "fx"),
                .fy = map.positive(prefix + "fy"),
                .cx = map.number(prefix + "cx"),
                .cy = map.number(prefix + "cy"),
                .cam_T_imu = {}};
  set_orb_distortion(map, prefix, camera);
  return camera;
}

// Old stereo files state the lenses as OpenCV does, before rectification: LEFT.K, LEFT.D, ….
Camera orb_raw_lens(const YamlMap& map, const std::string& side) {
  const Eigen::Matrix3d K = map.matrix(side + ".K", 3, 3);
  Camera camera{.width = checked_pixels(map.where(side + ".width"), map.number(side + ".width")),
                .height = checked_pixels(map.where(side + ".height"), map.number(side + ".height")),
                .fx = checked_positive(map.where(side + ".K"), K(0, 0)),
                .fy = checked_positive(map.where(side + ".K"), K(1, 1)),
                .cx = K(0, 2),
                .cy = K(1, 2),
                .cam_T_imu = {}};
  const Eigen::VectorXd d = map.numbers(side + ".D", 5, "coefficients");
  set_opencv_lens({d[0], d[1], d[2], d[3], d[4]}, camera);
  return camera;
}

// From the rectification: both cameras are turned, and then a baseline apart.
SE3 orb_raw_c1_T_c2(const YamlMap& map) {
  const auto rotation = [&](const char* key) {
    return checked_rotation(map.where(key), Eigen::Matrix3d(map.matrix(key, 3, 3)));
  };
  const Eigen::Matrix3d rect_R_c1 = rotation("LEFT.R"), rect_R_c2 = rotation("RIGHT.R");
  const Eigen::MatrixXd P = map.matrix("RIGHT.P", 3, 4);
  const double baseline = -P(0, 3) / checked_positive(map.where("RIGHT.P"), P(0, 0));
  return {rect_R_c1.transpose() * rect_R_c2,
          rect_R_c1.transpose() * Eigen::Vector3d(baseline, 0, 0)};
}

SE3 motion_of_rows(const YamlMap& map, const std::string& key) {
  const Eigen::MatrixXd M = map.matrix(key, 3, 4);
  return {checked_rotation(map.where(key), M.leftCols<3>()), M.col(3)};
}

// Whether the settings are of two cameras: any value of the second one, where it is, or, of a
// rectified pair, a value of the stereo.
bool orb_is_pair(const YamlMap& map) {
  if (has_any(map, "Camera2.") || map.has("Stereo.T_c1_c2") || map.has("Tlr")) return true;
  return orb_model(map) == "rectified" && (map.has("Stereo.b") || map.has("Stereo.ThDepth"));
}

// Where the second camera is against the first.
SE3 orb_c1_T_c2(const YamlMap& map) {
  if (map.has("Tlr")) return motion_of_rows(map, "Tlr");
  if (orb_model(map) == "rectified" && !map.has("Stereo.T_c1_c2")) {
    return SE3{Eigen::Matrix3d::Identity(), {map.positive("Stereo.b"), 0, 0}};
  }
  return map.motion("Stereo.T_c1_c2");
}

SE3 orb_imu_T_c1(const YamlMap& map) {
  if (map.has("Tbc")) return map.motion("Tbc");
  if (map.has("IMU.T_b_c1")) return map.motion("IMU.T_b_c1");
  throw InputError(fmt::format(
      "{}: is missing (Tbc in old files), expected where the camera is against the IMU: these are "
      "settings without an IMU",
      map.where("IMU.T_b_c1")));
}

std::vector<Camera> orb_cameras(const YamlMap& map) {
  const SE3 c1_T_imu = orb_imu_T_c1(map).inverse();
  const bool raw = std::ranges::any_of(std::array{"LEFT.K", "LEFT.D", "RIGHT.K", "RIGHT.D"},
                                       [&](const char* key) { return map.has(key); });
  std::vector<Camera> cameras{raw ? orb_raw_lens(map, "LEFT") : orb_lens(map, 1)};
  cameras[0].cam_T_imu = c1_T_imu;
  if (!raw && !orb_is_pair(map)) return cameras;
  const SE3 c1_T_c2 = raw ? orb_raw_c1_T_c2(map) : orb_c1_T_c2(map);
  const bool one_lens = orb_model(map) == "rectified" && !has_any(map, "Camera2.");
  const int lens = one_lens ? 1 : 2;
  cameras.push_back(raw ? orb_raw_lens(map, "RIGHT") : orb_lens(map, lens));
  cameras[1].cam_T_imu = c1_T_c2.inverse() * c1_T_imu;
  return cameras;
}

}  // namespace

KalibrCalibration read_orb(const fs::path& file, std::size_t cameras) {
  const YamlMap map = YamlMap::read(file, {});
  KalibrCalibration result{.cameras = orb_cameras(map)};
  result.cameras.resize(std::min(cameras, result.cameras.size()));
  result.time_offsets.resize(result.cameras.size());
  result.camera_topics.resize(result.cameras.size());
  result.imu_noise = {.accelerometer_noise_density = map.not_negative("IMU.NoiseAcc"),
                      .accelerometer_random_walk = map.not_negative("IMU.AccWalk"),
                      .gyroscope_noise_density = map.not_negative("IMU.NoiseGyro"),
                      .gyroscope_random_walk = map.not_negative("IMU.GyroWalk")};
  result.remarks.push_back(
      fmt::format("the calibration is that of {} (ORB-SLAM3); no time offset is known",
                  file.filename().string()));
  return result;
}

}  // namespace chasles
