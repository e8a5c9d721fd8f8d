#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/lens.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

Distortion read_model(const YamlMap& map, const std::string& key) {
  const std::string model = map.text(key);
  if (model == "radial-tangential") return Distortion::kRadtan;  // EuRoC's name
  if (const auto known = choice_of<Distortion>(model)) return *known;
  throw InputError(
      fmt::format("{}: '{}' is a model that is not known here, expected one of {}, or "
                  "radial-tangential: calibrate with one of these",
                  map.where(key), model, fmt::join(kChoiceNames<Distortion>, ", ")));
}

}  // namespace

int checked_pixels(const std::string& where, double value) {
  if (value >= 1 && value <= 1e5 && value == std::floor(value)) return static_cast<int>(value);
  throw InputError(
      fmt::format("{}: is {}, expected a whole number of pixels from 1 to 100000", where, value));
}

Camera read_pinhole(const YamlMap& map, const LensKeys& keys) {
  if (map.text("camera_model") != "pinhole") {
    throw InputError(fmt::format(
        "{}: '{}' is a model that is not known here, expected 'pinhole': calibrate with "
        "pinhole and, for a fisheye lens, equidistant",
        map.where("camera_model"), map.text("camera_model")));
  }
  const Eigen::Vector2d size = map.numbers("resolution", 2, "numbers: width, height [px]");
  const Eigen::Vector4d f = map.numbers("intrinsics", 4, "numbers: fx, fy, cx, cy [px]");
  Camera camera{.width = checked_pixels(map.where("resolution"), size[0]),
                .height = checked_pixels(map.where("resolution"), size[1]),
                .fx = checked_positive(map.where("intrinsics"), f[0]),
                .fy = checked_positive(map.where("intrinsics"), f[1]),
                .cx = f[2],
                .cy = f[3],
                .distortion = read_model(map, keys.distortion_model),
                .cam_T_imu = {}};
  if (camera.distortion != Distortion::kNone) {
    camera.coefficients = map.numbers(keys.coefficients, 4, "coefficients");
  }
  return camera;
}

}  // namespace chasles
