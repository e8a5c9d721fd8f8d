#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/imu_noise.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kFormat = "chasles-recording-1";
const Names kRigKeys{"fx", "fy", "cx", "cy", "baseline", "cam0_T_imu"};
const Names kNoiseKeys{"accelerometer_noise_density", "accelerometer_random_walk",
                       "gyroscope_noise_density", "gyroscope_random_walk"};

YamlMap::Keys document_keys() {
  Names known{"format", "name"};
  known.insert(known.end(), kRigKeys.begin(), kRigKeys.end());
  known.insert(known.end(), {"remarks", "linear_sigma", "angular_sigma", "pixel_sigma"});
  known.insert(known.end(), {"single_pixel_sigma", "cameras", "imu_convention"});
  known.insert(known.end(), kNoiseKeys.begin(), kNoiseKeys.end());
  known.insert(known.end(),
               {"accelerometer_range", "gyroscope_range", "noise_is_exact", "truth_level"});
  return {.known = known, .needed = {"format", "name"}};
}

YamlMap::Keys camera_keys() {
  return {.known = {"resolution", "intrinsics", "distortion_model", "distortion_coeffs",
                    "cam_T_imu", "timeshift_cam_imu", "readout_time", "readout_direction"},
          .needed = {"resolution", "intrinsics", "distortion_model", "cam_T_imu"}};
}

// Whether one of these keys is present.
bool any(const YamlMap& map, const Names& keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return map.has(key); });
}

std::optional<StereoRig> read_rig(const YamlMap& map) {
  // Without IMU and cameras it is a recording of a rig.
  if (!any(map, kRigKeys) && any(map, {"cameras", "imu_convention"})) return std::nullopt;
  for (const std::string& key : kRigKeys) map.need(key);
  return StereoRig{.fx = map.positive("fx"),
                   .fy = map.positive("fy"),
                   .cx = map.number("cx"),
                   .cy = map.number("cy"),
                   .baseline = map.positive("baseline"),
                   .cam0_T_imu = map.motion("cam0_T_imu")};
}

Camera read_camera(const YamlMap& map) {
  Camera camera =
      read_lens(map, {.distortion_model = "distortion_model", .coefficients = "distortion_coeffs"});
  camera.cam_T_imu = map.motion("cam_T_imu");
  camera.shutter = read_shutter(map);
  return camera;
}

std::optional<ImuConvention> read_imu_convention(const YamlMap& map) {
  if (!map.has("imu_convention")) return std::nullopt;
  const std::string text = map.text("imu_convention");
  if (const auto convention = choice_of<ImuConvention>(text)) return convention;
  throw InputError(fmt::format("{}: is '{}', expected one of {}", map.where("imu_convention"), text,
                               fmt::join(kChoiceNames<ImuConvention>, ", ")));
}

std::optional<ImuNoise> read_imu_noise(const YamlMap& map) {
  if (!any(map, kNoiseKeys)) return std::nullopt;
  for (const std::string& key : kNoiseKeys) map.need(key);
  return ImuNoise{.accelerometer_noise_density = map.not_negative("accelerometer_noise_density"),
                  .accelerometer_random_walk = map.not_negative("accelerometer_random_walk"),
                  .gyroscope_noise_density = map.not_negative("gyroscope_noise_density"),
                  .gyroscope_random_walk = map.not_negative("gyroscope_random_walk"),
                  .exact = read_noise_is_exact(map)};
}

std::optional<bool> read_truth_level(const YamlMap& map) {
  if (!map.has("truth_level")) return std::nullopt;
  return map.flag("truth_level", "the z axis of the truth's world points up");
}

// Standard deviations, one for each of `size` components; none where the key is missing.
std::optional<Eigen::VectorXd> read_sigma(const YamlMap& map, const std::string& key,
                                          std::size_t size) {
  if (!map.has(key)) return std::nullopt;
  const Eigen::VectorXd sigma = map.numbers(key, size, "standard deviations");
  for (const double value : sigma) checked_positive(map.where(key), value);
  return sigma;
}

void read_stated_noise(const YamlMap& map, FolderCalibration& calibration) {
  const auto linear = read_sigma(map, "linear_sigma", 3);
  const auto angular = read_sigma(map, "angular_sigma", 3);
  if (linear.has_value() != angular.has_value()) {
    throw InputError(map.where(linear ? "linear_sigma" : "angular_sigma") +
                     ": linear_sigma and angular_sigma are expected both or neither");
  }
  if (linear) calibration.velocity_sigma = BodyVelocitySigma{*linear, *angular};
  if (const auto pixels = read_sigma(map, "pixel_sigma", 4)) calibration.pixel_sigma = *pixels;
  if (map.has("single_pixel_sigma")) {
    calibration.single_pixel_sigma = map.positive("single_pixel_sigma");
  }
  calibration.imu_noise = read_imu_noise(map);
  calibration.imu_range = read_imu_range(map);
}

}  // namespace

FolderCalibration read_calibration(const std::filesystem::path& file) {
  const YamlMap map = YamlMap::read(file, document_keys());
  if (map.text("format") != kFormat) {
    throw InputError(fmt::format("{}: is '{}', expected '{}'", map.where("format"),
                                 map.text("format"), kFormat));
  }
  FolderCalibration calibration{.name = map.text("name"),
                                .rig = read_rig(map),
                                .imu_convention = read_imu_convention(map),
                                .remarks = map.texts("remarks"),
                                .truth_level = read_truth_level(map)};
  read_stated_noise(map, calibration);
  if (map.has("cameras")) {
    for (const YamlMap& entry : map.maps("cameras", camera_keys())) {
      calibration.cameras.push_back(read_camera(entry));
      calibration.time_offsets.push_back(read_time_offset(entry));
    }
  }
  return calibration;
}

}  // namespace chasles
