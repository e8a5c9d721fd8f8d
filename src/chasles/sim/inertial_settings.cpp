#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/reject_setting.hpp>

namespace chasles {
namespace {

InertialScene hallway() {
  return {.name = "hallway",
          .doc = "a walk of 69 s around a block of corridors, one camera, IMU after the paper",
          .settings = {}};
}

InertialScene turntable() {
  InertialScene scene{
      .name = "turntable",
      .doc = "twice around a cube that is always in view, landmarks seen throughout",
      .settings = {}};
  InertialSettings& settings = scene.settings;
  settings.name = "turntable";
  settings.geometry = Geometry::kTurntable;
  settings.rest_duration = settings.start_duration = 0;
  settings.landmarks_in_view = settings.cube_landmarks;
  settings.max_range = 20;
  settings.occlusion = false;
  settings.keep_ids = true;
  return scene;
}

InertialScene trajectory() {
  InertialScene scene{.name = "trajectory",
                      .doc = "along a given trajectory, among landmarks scattered around it",
                      .settings = {}};
  scene.settings.name = "trajectory";
  scene.settings.geometry = Geometry::kTrajectory;
  scene.settings.knot_interval = 0.1;
  scene.settings.landmarks_in_view = scene.settings.visible_landmarks;
  return scene;
}

// A pedestrian with a stereo pair on the chest, pointing slightly down; a MEMS IMU.
InertialScene walk() {
  InertialScene scene{.name = "walk",
                      .doc = "a pedestrian's way of 320 m along two loops of corridors and a hall",
                      .settings = {}};
  InertialSettings& settings = scene.settings;
  settings.name = "walk";
  settings.geometry = Geometry::kWalk;
  settings.rest_duration = 4;
  settings.start_duration = 2;
  settings.hall_length = 24;
  settings.hall_width = 16;
  settings.corridor_width = 2.6;
  settings.sections = 16;
  settings.walking_speed = 1.3;
  settings.step_rate = 1.8;
  settings.turn_duration = 1.6;
  settings.imu_rate = 200;
  settings.frame_rate = 20;
  settings.image_width = 752;
  settings.image_height = 480;
  settings.focal_length = 458;
  settings.center_u = 375.5;
  settings.center_v = 239.5;
  settings.baseline = 0.11;
  settings.camera_tilt_y = 0.05;
  settings.min_range = 1;
  settings.accelerometer_noise_density = 2e-3;
  settings.gyroscope_noise_density = 1.7e-4;
  return scene;
}

std::array<double, LensCoefficients::kMost> stated_coefficients(const InertialSettings& s) {
  if (s.distortion == Distortion::kNone) return {};
  return {s.distortion_1, s.distortion_2,  s.distortion_3,  s.distortion_4,
          s.distortion_5, s.distortion_6,  s.distortion_7,  s.distortion_8,
          s.distortion_9, s.distortion_10, s.distortion_11, s.distortion_12};
}

}  // namespace

LensCoefficients lens_coefficients(const InertialSettings& settings) {
  return LensCoefficients(without_padding(settings.distortion, stated_coefficients(settings)));
}

void validate(const InertialSettings& settings) {
  validate_fields(settings, kSimulationSetting);
  const std::string fault = coefficients_fault(settings.distortion, lens_coefficients(settings));
  if (!fault.empty()) {
    throw UsageError("distortion_1, ...: the lens of the setting distortion " + fault);
  }
  const auto above = [](std::string_view high, double high_value, std::string_view low,
                        double low_value) {
    if (high_value > low_value) return;
    reject_setting(high, fmt::format("{} m", high_value),
                   fmt::format("more than {}, {} m", low, low_value));
  };
  above("max_range", settings.max_range, "min_range", settings.min_range);
  above("landmark_farthest", settings.landmark_farthest, "landmark_nearest",
        settings.landmark_nearest);
  above("corridor_height", settings.corridor_height, "imu_height", settings.imu_height);
  above("hall_length", settings.hall_length, "corridor_width", settings.corridor_width);
  above("hall_width", settings.hall_width, "corridor_width", settings.corridor_width);
  above("circle_radius", settings.circle_radius, "radial_sway", settings.radial_sway);
  if (settings.exposure_time * settings.frame_rate > 1) {
    reject_setting(
        "exposure_time", fmt::format("{} s", settings.exposure_time),
        fmt::format("at most the time between two frames, {} s", 1 / settings.frame_rate));
  }
  if (settings.readout_time * settings.frame_rate > 1) {
    reject_setting(
        "readout_time", fmt::format("{} s", settings.readout_time),
        fmt::format("at most the time between two frames, {} s", 1 / settings.frame_rate));
  }
  if (2 * settings.image_border >= std::min(settings.image_width, settings.image_height)) {
    reject_setting("image_border", fmt::format("{} px", settings.image_border),
                   fmt::format("less than half of the image of {} x {} px", settings.image_width,
                               settings.image_height));
  }
}

const std::vector<InertialScene>& inertial_scenes() {
  static const std::vector<InertialScene> scenes = {hallway(), turntable(), trajectory(), walk()};
  return scenes;
}

InertialScene inertial_scene(const std::string& name) {
  std::string known;
  for (const InertialScene& scene : inertial_scenes()) {
    if (scene.name == name) return scene;
    known += (known.empty() ? "" : ", ") + scene.name;
  }
  throw UsageError(fmt::format("unknown scene '{}': expected one of {}", name, known));
}

}  // namespace chasles
