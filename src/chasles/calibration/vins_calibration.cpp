#include <array>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

double value_or_zero(const YamlMap& map, const std::string& key) {
  return map.has(key) ? map.number(key) : 0;
}

// VINS itself takes a coefficient that is missing for zero, and so a misspelt one.
void set_vins_pinhole(const YamlMap& lens, Camera& camera, std::vector<std::string>& remarks) {
  const YamlMap f =
      lens.map("projection_parameters", {.known = {}, .needed = {"fx", "fy", "cx", "cy"}});
  camera.fx = f.positive("fx");
  camera.fy = f.positive("fy");
  camera.cx = f.number("cx");
  camera.cy = f.number("cy");
  if (!lens.has("distortion_parameters")) {
    remarks.push_back(lens.where("distortion_parameters") +
                      " is missing: the lens is taken to have no distortion");
    return;
  }
  const YamlMap d = lens.map("distortion_parameters", {});
  camera.coefficients = {d.number("k1"), d.number("k2"), d.number("p1"), d.number("p2")};
  camera.distortion = Distortion::kRadtan;
  if (!camera.coefficients.is_zero()) return;
  camera.distortion = Distortion::kNone;
  camera.coefficients = {};
}

// The unified model: gamma1, gamma2, u0 and v0 are fx, fy, cx and cy.
void set_vins_mei(const YamlMap& lens, Camera& camera) {
  const YamlMap p =
      lens.map("projection_parameters", {.known = {}, .needed = {"gamma1", "gamma2", "u0", "v0"}});
  const YamlMap mirror = lens.map("mirror_parameters", {.known = {}, .needed = {"xi"}});
  const YamlMap d = lens.map("distortion_parameters", {});
  camera.fx = p.positive("gamma1");
  camera.fy = p.positive("gamma2");
  camera.cx = p.number("u0");
  camera.cy = p.number("v0");
  const std::array k{mirror.number("xi"), d.number("k1"), d.number("k2"), d.number("p1"),
                     d.number("p2")};
  set_lens(lens.where("mirror_parameters"), Distortion::kOmni,
           without_padding(Distortion::kOmni, k), camera);
}

// Its mu, mv, u0 and v0 are fx, fy, cx and cy, and its k2 to k5 the four coefficients.
void set_vins_fisheye(const YamlMap& lens, Camera& camera) {
  const YamlMap p = lens.map("projection_parameters", {.known = {}, .needed = {"mu", "mv", "u0"}});
  camera.fx = p.positive("mu");
  camera.fy = p.positive("mv");
  camera.cx = p.number("u0");
  camera.cy = p.number("v0");
  camera.coefficients = {p.number("k2"), p.number("k3"), p.number("k4"), p.number("k5")};
  camera.distortion = Distortion::kEquidistant;
}

Camera vins_lens(const YamlMap& lens, std::vector<std::string>& remarks) {
  Camera camera{.width = checked_pixels(lens.where("image_width"), lens.number("image_width")),
                .height = checked_pixels(lens.where("image_height"), lens.number("image_height")),
                .cam_T_imu = {}};
  const std::string model = lower_case(lens.text("model_type"));
  if (model == "pinhole") {
    set_vins_pinhole(lens, camera, remarks);
  } else if (model == "kannala_brandt") {
    set_vins_fisheye(lens, camera);
  } else if (model == "mei") {
    set_vins_mei(lens, camera);
  } else {
    throw InputError(fmt::format(
        "{}: is {}, a model that is not supported, expected PINHOLE, KANNALA_BRANDT or MEI: "
        "calibrate with one of these",
        lens.where("model_type"), lens.text("model_type")));
  }
  return camera;
}

// VINS-Fusion names a file for each camera, VINS-Mono has the lens of its only one in the same
// file.
Camera vins_camera(const fs::path& file, const YamlMap& map, std::size_t c,
                   std::vector<std::string>& remarks) {
  const std::string key = fmt::format("cam{}_calib", c);
  if (!map.has(key) && map.has("model_type") && c == 0) return vins_lens(map, remarks);
  const fs::path lens = file.parent_path() / map.text(key);
  if (!fs::exists(lens)) {
    throw InputError(fmt::format("{}: names {}, which is not there, expected the lens of cam{}",
                                 map.where(key), lens.string(), c));
  }
  return vins_lens(YamlMap::read(lens, {}), remarks);
}

// By body_T_cam0 of VINS-Fusion, or by rotation and translation of VINS-Mono: camera to IMU.
SE3 vins_extrinsics(const YamlMap& map, std::size_t c) {
  const std::string key = fmt::format("body_T_cam{}", c);
  if (map.has(key) || !map.has("extrinsicRotation")) return map.motion(key).inverse();
  const Eigen::Matrix3d R = checked_rotation(
      map.where("extrinsicRotation"), Eigen::Matrix3d(map.matrix("extrinsicRotation", 3, 3)));
  const Eigen::Vector3d p = map.numbers("extrinsicTranslation", 3, "numbers [m]");
  return SE3{R, p}.inverse();
}

void check_vins(const YamlMap& map) {
  if (map.has("imu") && map.number("imu") == 0) {
    throw InputError(
        fmt::format("{}: is 0: this configuration has no IMU, expected one with "
                    "imu: 1, acc_n, gyr_n, acc_w, gyr_w and body_T_cam0",
                    map.where("imu")));
  }
  if (map.has("estimate_extrinsic") && map.number("estimate_extrinsic") == 2) {
    throw InputError(fmt::format(
        "{}: is 2: where the cameras are against the IMU is not known, expected 0 or 1, and the "
        "result of VINS in body_T_cam0",
        map.where("estimate_extrinsic")));
  }
}

std::string text_or_empty(const YamlMap& map, const std::string& key) {
  return map.has(key) ? map.text(key) : "";
}

// Without a number, what else is there of a second camera makes it two.
std::size_t vins_cameras(const YamlMap& map) {
  if (!map.has("num_of_cam")) {
    const bool second = map.has("body_T_cam1") || map.has("cam1_calib") || map.has("image1_topic");
    return second ? 2 : 1;
  }
  return map.number("num_of_cam") >= 2 ? 2 : 1;
}

}  // namespace

KalibrCalibration read_vins(const fs::path& file, std::size_t cameras) {
  const YamlMap map = YamlMap::read(file, {});
  check_vins(map);
  KalibrCalibration result{.noise_of_samples = true};
  for (std::size_t c = 0; c < std::min(cameras, vins_cameras(map)); ++c) {
    Camera camera = vins_camera(file, map, c, result.remarks);
    camera.cam_T_imu = vins_extrinsics(map, c);
    if (value_or_zero(map, "rolling_shutter") != 0) {
      const std::string key = "rolling_shutter_tr";
      camera.shutter.readout = checked_readout(map.where(key), map.number(key));
    }
    result.cameras.push_back(camera);
    const std::string topic = text_or_empty(map, fmt::format("image{}_topic", c));
    result.camera_topics.push_back(topic.empty() && c == 0 ? text_or_empty(map, "image_topic")
                                                           : topic);
    // The stamps of VINS are those of an image's middle row.
    result.time_offsets.push_back(
        from_seconds(value_or_zero(map, "td") - camera.shutter.readout / 2));
  }
  result.imu_noise = {.accelerometer_noise_density = map.not_negative("acc_n"),
                      .accelerometer_random_walk = map.not_negative("acc_w"),
                      .gyroscope_noise_density = map.not_negative("gyr_n"),
                      .gyroscope_random_walk = map.not_negative("gyr_w")};
  result.imu_topic = text_or_empty(map, "imu_topic");
  result.remarks.push_back(
      fmt::format("the calibration is that of {} (VINS)", file.filename().string()));
  remark_on_time_offsets(result.time_offsets, result.remarks);
  return result;
}

}  // namespace chasles
