#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

[[noreturn]] void not_supported(const YamlMap& map, const std::string& key) {
  throw InputError(fmt::format("{}: '{}' is a model that is not supported, {}", map.where(key),
                               map.text(key), expected_lenses()));
}

std::vector<double> list_at(const YamlMap& map, const std::string& key, const char* what) {
  if (!map.has(key)) return {};
  const Eigen::VectorXd all = map.numbers(key, map.count(key), what);
  return {all.begin(), all.end()};
}

// OpenCV writes zeros for the coefficients of radtan that were not asked for.
void read_distortion(const YamlMap& map, const LensKeys& keys, Camera& camera) {
  const auto model = lens_model_named(map.text(keys.distortion_model));
  if (!model) not_supported(map, keys.distortion_model);
  const std::vector<double> all = list_at(map, keys.coefficients, "coefficients");
  const bool padded = *model == Distortion::kRadtan || *model == Distortion::kNone;
  const std::span<const double> stated = padded ? without_padding(*model, all) : std::span(all);
  if (*model == Distortion::kNone && !stated.empty()) {
    throw InputError(map.where(keys.coefficients) +
                     ": is not zero, expected none with the distortion_model 'none'");
  }
  set_lens(map.where(keys.coefficients), *model, stated, camera);
}

// How many of Kalibr's intrinsics come before the focal lengths.
std::size_t own_intrinsics(Distortion model) {
  if (model == Distortion::kOmni) return 1;
  return model == Distortion::kDoubleSphere || model == Distortion::kEucm ? 2 : 0;
}

Camera sized_camera(const YamlMap& map, std::span<const double> f) {
  const Eigen::Vector2d size = map.numbers("resolution", 2, "numbers: width, height [px]");
  return {.width = checked_pixels(map.where("resolution"), size[0]),
          .height = checked_pixels(map.where("resolution"), size[1]),
          .fx = checked_positive(map.where("intrinsics"), f[0]),
          .fy = checked_positive(map.where("intrinsics"), f[1]),
          .cx = f[2],
          .cy = f[3],
          .cam_T_imu = {}};
}

std::vector<double> with(std::vector<double> first, std::span<const double> then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

}  // namespace

std::string expected_lenses() {
  return "expected a pinhole camera with one of " + lens_model_names() +
         ": calibrate with one of these";
}

void set_lens(const std::string& where, Distortion model, std::span<const double> coefficients,
              Camera& camera) {
  const std::string fault = coefficients_fault(model, coefficients);
  if (!fault.empty()) throw InputError(fmt::format("{}: {}", where, fault));
  camera.distortion = model;
  camera.coefficients = LensCoefficients(coefficients);
}

int checked_pixels(const std::string& where, double value) {
  if (value >= 1 && value <= 1e5 && value == std::floor(value)) return static_cast<int>(value);
  throw InputError(
      fmt::format("{}: is {}, expected a whole number of pixels from 1 to 100000", where, value));
}

Camera read_lens(const YamlMap& map, const LensKeys& keys) {
  const Eigen::Vector4d f = map.numbers("intrinsics", 4, "numbers: fx, fy, cx, cy [px]");
  Camera camera = sized_camera(map, std::span(f.data(), 4));
  read_distortion(map, keys, camera);
  return camera;
}

Camera read_kalibr_lens(const YamlMap& map, const LensKeys& keys) {
  const std::string name = lower_case(map.text("camera_model"));
  if (name == "pinhole") return read_lens(map, keys);
  const auto model = lens_model_named(name);
  const std::size_t own = model ? own_intrinsics(*model) : 0;
  if (own == 0) not_supported(map, "camera_model");
  const char* const what = own == 1                      ? "numbers: xi, fx, fy, cx, cy"
                           : *model == Distortion::kEucm ? "numbers: alpha, beta, fx, fy, cx, cy"
                                                         : "numbers: xi, alpha, fx, fy, cx, cy";
  const Eigen::VectorXd all = map.numbers("intrinsics", own + 4, what);
  const std::span<const double> intrinsics(all.data(), own + 4);
  Camera camera = sized_camera(map, intrinsics.subspan(own));
  Camera further;  // of the distortion that follows the camera model
  read_distortion(map, keys, further);
  const bool radtan = further.distortion == Distortion::kRadtan && *model == Distortion::kOmni;
  if (further.distortion != Distortion::kNone && !radtan) {
    throw InputError(fmt::format("{}: is {}, expected {} with the camera_model {}",
                                 map.where(keys.distortion_model), name_of(further.distortion),
                                 *model == Distortion::kOmni ? "none or radtan" : "none", name));
  }
  const std::vector<double> coefficients =
      with({all.data(), all.data() + own}, further.coefficients);
  set_lens(map.where("intrinsics"), *model, coefficients, camera);
  return camera;
}

KalibrLens kalibr_lens(const Camera& camera) {
  const std::size_t own = own_intrinsics(camera.distortion);
  const std::span<const double> all(camera.coefficients),
      first = all.first(std::min(own, all.size())), further = all.subspan(first.size());
  KalibrLens lens{.camera_model = own == 0 ? "pinhole" : std::string(name_of(camera.distortion)),
                  .intrinsics = with({first.begin(), first.end()},
                                     std::array{camera.fx, camera.fy, camera.cx, camera.cy}),
                  .distortion_model = std::string(name_of(camera.distortion)),
                  .coefficients = {further.begin(), further.end()}};
  if (own > 0) lens.distortion_model = further.empty() ? "none" : "radtan";
  return lens;
}

}  // namespace chasles
