#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <stdexcept>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/sim/refuse_setting.hpp>
#include <chasles/sim/street_settings.hpp>

namespace chasles {
namespace {

struct Range {
  std::string_view field;
  double low, high;
};

// Wide enough for every drive somebody could mean, narrow enough that the number of frames stays
// finite and that no image, street or wave is empty.
constexpr std::array kRanges = std::to_array<Range>({
    {"block_length", 1, 1e5},      {"block_width", 1, 1e5},      {"corner_length", 0.1, 1e4},
    {"cruise_speed", 0.1, 100},    {"corner_speed", 0.1, 100},   {"acceleration", 0.01, 100},
    {"stop_every", 0, 1e6},        {"stop_duration", 0, 3600},   {"road_amplitude", 0, 100},
    {"road_wavelength", 0.1, 1e6}, {"roll_amplitude", 0, 0.5},   {"pitch_amplitude", 0, 0.5},
    {"sway_wavelength", 0.1, 1e6}, {"street_width", 1, 1e4},     {"facade_height", 0, 1e3},
    {"imu_height", 0.01, 100},     {"focal_length", 1, 1e5},     {"center_u", -1e5, 1e5},
    {"center_v", -1e5, 1e5},       {"image_width", 1, 1e5},      {"image_height", 1, 1e5},
    {"baseline", 1e-3, 100},       {"camera_x", -10, 10},        {"camera_y", -10, 10},
    {"camera_z", -10, 10},         {"camera_tilt_x", -3.2, 3.2}, {"camera_tilt_y", -3.2, 3.2},
    {"camera_tilt_z", -3.2, 3.2},  {"frame_rate", 0.01, 1000},   {"features_per_frame", 0, 1e5},
    {"track_life", 0.01, 1e6},     {"shortest_track", 1, 1e6},   {"image_border", 0, 1e5},
    {"min_depth", 0.1, 1e4},       {"max_depth", 0.1, 1e4},      {"velocities_per_frame", 1, 1000},
    {"linear_sigma", 0, 100},      {"angular_sigma", 0, 100},    {"gyro_bias_x", -10, 10},
    {"gyro_bias_y", -10, 10},      {"gyro_bias_z", -10, 10},     {"velocity_scale", 0.1, 10},
    {"pixel_sigma", 0, 100},       {"disparity_sigma", 0, 100},  {"outlier_fraction", 0, 1},
    {"moving_fraction", 0, 1},     {"moving_speed", 0, 100},     {"dropped_fraction", 0, 1},
});

// NaN fails both comparisons' positive form, so it is refused too.
void check(const Range& range, double value, const char* unit) {
  if (value >= range.low && value <= range.high) return;
  const std::string space = *unit ? " " : "";
  refuse_setting(range.field, fmt::format("{}{}{}", value, space, unit),
                 fmt::format("a number from {} to {}{}{}", range.low, range.high, space, unit));
}

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
  for_each_field(settings, [](const char* name, const auto& value, const char* unit, const char*) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::same_as<Value, int> || std::same_as<Value, double>) {
      const auto range = std::ranges::find(kRanges, std::string_view(name), &Range::field);
      if (range == kRanges.end()) throw std::logic_error(fmt::format("{} has no range", name));
      check(*range, static_cast<double>(value), unit);
    }
  });
  const auto wrong = settings.route.find_first_not_of("LRS");
  if (wrong != std::string::npos) {
    refuse_setting("route", settings.route,
                   fmt::format("only the letters L, R and S; letter {} is '{}'", wrong + 1,
                               settings.route[wrong]));
  }
  if (settings.corner_speed > settings.cruise_speed) {
    refuse_setting("corner_speed", fmt::format("{} m/s", settings.corner_speed),
                   fmt::format("at most cruise_speed, {} m/s", settings.cruise_speed));
  }
  if (settings.max_depth <= settings.min_depth) {
    refuse_setting("max_depth", fmt::format("{} m", settings.max_depth),
                   fmt::format("more than min_depth, {} m", settings.min_depth));
  }
  if (2 * settings.image_border >= std::min(settings.image_width, settings.image_height)) {
    refuse_setting("image_border", fmt::format("{} px", settings.image_border),
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
