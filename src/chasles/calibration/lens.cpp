#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr const char* kSupported =
    "expected a pinhole camera with none, radtan (also radial-tangential, plumb_bob; four or five "
    "coefficients) or equidistant (also equi, fisheye): calibrate with one of these";

struct ModelName {
  std::string_view name;
  Distortion model;
};
// By the names of Kalibr, EuRoC, OpenVINS, ROS and OpenCV, in small letters.
constexpr std::array kModelNames{ModelName{"none", Distortion::kNone},
                                 ModelName{"radtan", Distortion::kRadtan},
                                 ModelName{"radial-tangential", Distortion::kRadtan},
                                 ModelName{"radial_tangential", Distortion::kRadtan},
                                 ModelName{"plumb_bob", Distortion::kRadtan},
                                 ModelName{"equidistant", Distortion::kEquidistant},
                                 ModelName{"equi", Distortion::kEquidistant},
                                 ModelName{"fisheye", Distortion::kEquidistant}};

[[noreturn]] void not_supported(const YamlMap& map, const std::string& key) {
  throw InputError(fmt::format("{}: '{}' is a model that is not supported, {}", map.where(key),
                               map.text(key), kSupported));
}

// k1, k2, p1, p2 and, of radtan, k3. OpenCV writes zeros for the coefficients of the models that
// were not asked for.
void read_coefficients(const YamlMap& map, const std::string& key, Camera& camera) {
  const bool radtan = camera.distortion == Distortion::kRadtan;
  const std::size_t count = map.has(key) ? map.count(key) : 0;
  if (count < 4 || (!radtan && count > 4)) {
    throw InputError(fmt::format("{}: has {} coefficients, expected {} with the model {}",
                                 map.where(key), count, radtan ? "4 coefficients, or 5" : "4",
                                 name_of(camera.distortion)));
  }
  const Eigen::VectorXd all = map.numbers(key, count, "coefficients");
  camera.coefficients = all.head<4>();
  if (count > 4) camera.radtan_k3 = all[4];
  if (count <= 5 || all.tail(all.size() - 5).isZero(0)) return;
  throw InputError(
      fmt::format("{}: has {} coefficients, those of a rational model or of a thin prism, {}",
                  map.where(key), count, kSupported));
}

void read_distortion(const YamlMap& map, const LensKeys& keys, Camera& camera) {
  const auto model = distortion_named(map.text(keys.distortion_model));
  if (!model) not_supported(map, keys.distortion_model);
  camera.distortion = *model;
  if (camera.distortion != Distortion::kNone) {
    read_coefficients(map, keys.coefficients, camera);
  } else if (map.has(keys.coefficients)) {
    const std::size_t count = map.count(keys.coefficients);
    if (map.numbers(keys.coefficients, count, "coefficients").isZero(0)) return;
    throw InputError(map.where(keys.coefficients) +
                     ": is not zero, expected none with the distortion_model 'none'");
  }
}

}  // namespace

std::optional<Distortion> distortion_named(const std::string& name) {
  const auto* found = std::ranges::find(kModelNames, lower_case(name), &ModelName::name);
  return found == kModelNames.end() ? std::nullopt : std::optional(found->model);
}

int checked_pixels(const std::string& where, double value) {
  if (value >= 1 && value <= 1e5 && value == std::floor(value)) return static_cast<int>(value);
  throw InputError(
      fmt::format("{}: is {}, expected a whole number of pixels from 1 to 100000", where, value));
}

Camera read_lens(const YamlMap& map, const LensKeys& keys) {
  const Eigen::Vector2d size = map.numbers("resolution", 2, "numbers: width, height [px]");
  const Eigen::Vector4d f = map.numbers("intrinsics", 4, "numbers: fx, fy, cx, cy [px]");
  Camera camera{.width = checked_pixels(map.where("resolution"), size[0]),
                .height = checked_pixels(map.where("resolution"), size[1]),
                .fx = checked_positive(map.where("intrinsics"), f[0]),
                .fy = checked_positive(map.where("intrinsics"), f[1]),
                .cx = f[2],
                .cy = f[3],
                .cam_T_imu = {}};
  read_distortion(map, keys, camera);
  return camera;
}

Camera read_pinhole(const YamlMap& map, const LensKeys& keys) {
  if (lower_case(map.text("camera_model")) != "pinhole") not_supported(map, "camera_model");
  return read_lens(map, keys);
}

}  // namespace chasles
