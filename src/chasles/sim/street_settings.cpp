#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/sim/reject_setting.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {
namespace {

StreetSettings gnss_ins() {
  StreetSettings settings;
  settings.name = "street-ins";
  settings.linear_sigma = 0.03;
  settings.angular_sigma = 0.003;
  settings.gyro_bias_x = settings.gyro_bias_y = settings.gyro_bias_z = 0;
  return settings;
}

StreetSettings exact() {
  StreetSettings settings = gnss_ins();
  settings.name = "street-exact";
  settings.linear_sigma = settings.angular_sigma = 0;
  settings.pixel_sigma = settings.outlier_fraction = 0;
  return settings;
}

}  // namespace

void validate(const StreetSettings& settings) {
  validate_fields(settings, kSimulationSetting);
  const auto wrong = settings.route.find_first_not_of("LRS");
  if (wrong != std::string::npos) {
    reject_setting("route", settings.route,
                   fmt::format("only the letters L, R and S; letter {} is '{}'", wrong + 1,
                               settings.route[wrong]));
  }
  if (settings.corner_speed > settings.cruise_speed) {
    reject_setting("corner_speed", fmt::format("{} m/s", settings.corner_speed),
                   fmt::format("at most cruise_speed, {} m/s", settings.cruise_speed));
  }
  if (settings.max_depth <= settings.min_depth) {
    reject_setting("max_depth", fmt::format("{} m", settings.max_depth),
                   fmt::format("more than min_depth, {} m", settings.min_depth));
  }
  if (2 * settings.image_border >= std::min(settings.image_width, settings.image_height)) {
    reject_setting("image_border", fmt::format("{} px", settings.image_border),
                   fmt::format("less than half of the image of {} x {} px", settings.image_width,
                               settings.image_height));
  }
}

const std::vector<StreetScene>& street_scenes() {
  static const std::vector<StreetScene> scenes = {
      {"street", "noisy velocities with a gyroscope bias, 0.5 px, 2 % outliers", {}},
      {"street-ins", "as street, with the velocities of a GNSS/INS and no bias", gnss_ins()},
      {"street-exact", "no error in any measurement", exact()},
  };
  return scenes;
}

StreetSettings street_scene(const std::string& name) {
  std::string known;
  for (const StreetScene& scene : street_scenes()) {
    if (scene.name == name) return scene.settings;
    known += (known.empty() ? "" : ", ") + scene.name;
  }
  throw UsageError(fmt::format("unknown scene '{}': expected one of {}", name, known));
}

}  // namespace chasles
