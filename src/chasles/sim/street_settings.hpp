#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <chasles/base/settings.hpp>

namespace chasles {

// The only list of settings: type, name, default, least, most, unit, meaning. It defines the
// struct, the command line, the help and the checks. Only numbers have a least and a most. These
// are wide enough for every realistic run, and narrow enough that the number of frames stays finite
// and that no image, street or wave is empty.
// clang-format off
#define CHASLES_STREET_FIELDS(FIELD)                                                              \
  FIELD(std::string, name, "street", 0, 0, "", "name of the recording")                           \
  FIELD(std::uint64_t, seed, 1, 0, 0, "", "chooses all random numbers: landmarks and noise")      \
  /* the drive */                                                                                 \
  FIELD(std::string, route, "LLLSRRR", 0, 0, "", "turn at each crossing: L, R, or S straight on") \
  FIELD(double, block_length, 100, 1, 1e5, "m", "between crossings along x, the first direction of travel") \
  FIELD(double, block_width, 80, 1, 1e5, "m", "between crossings along y")                        \
  FIELD(double, corner_length, 20, 0.1, 1e4, "m", "length of the path of a turn of 90 degrees")  \
  FIELD(double, cruise_speed, 8, 0.1, 100, "m/s", "speed between the corners")                    \
  FIELD(double, corner_speed, 4, 0.1, 100, "m/s", "speed in the corners")                         \
  FIELD(double, acceleration, 1.5, 0.01, 100, "m/s^2", "mean of a change of speed; the peak is 35/16 of it") \
  FIELD(int, stop_every, 3, 0, 1e6, "corners", "stop before every n-th turn; 0: never")           \
  FIELD(double, stop_duration, 3, 0, 3600, "s", "how long a stop lasts")                          \
  FIELD(double, road_amplitude, 0.15, 0, 100, "m", "height of the road's waves")                  \
  FIELD(double, road_wavelength, 60, 0.1, 1e6, "m", "length of the road's waves")                 \
  FIELD(double, roll_amplitude, 0.02, 0, 0.5, "rad", "swaying about the forward axis")            \
  FIELD(double, pitch_amplitude, 0.015, 0, 0.5, "rad", "swaying about the left axis")             \
  FIELD(double, sway_wavelength, 25, 0.1, 1e6, "m", "distance travelled during one period of the swaying")              \
  /* the street */                                                                                \
  FIELD(double, street_width, 20, 1, 1e4, "m", "from facade to facade")                           \
  FIELD(double, facade_height, 9, 0, 1e3, "m", "of the buildings, above the road's mean")         \
  FIELD(double, imu_height, 0.93, 0.01, 100, "m", "of the IMU above the road")                    \
  /* the cameras (defaults: KITTI, 2011_09_26) */                                                 \
  FIELD(double, focal_length, 707.0912, 1, 1e5, "px", "fx = fy")                                  \
  FIELD(double, center_u, 601.8873, -1e5, 1e5, "px", "principal point, to the right")             \
  FIELD(double, center_v, 183.1104, -1e5, 1e5, "px", "principal point, down")                     \
  FIELD(int, image_width, 1241, 1, 1e5, "px", "of both images")                                   \
  FIELD(int, image_height, 376, 1, 1e5, "px", "of both images")                                   \
  FIELD(double, baseline, 0.53715, 1e-3, 100, "m", "from the left camera to the right one")       \
  FIELD(double, camera_x, 1.1439, -10, 10, "m", "left camera in the IMU frame, forward")          \
  FIELD(double, camera_y, -0.3127, -10, 10, "m", "left camera in the IMU frame, to the left")     \
  FIELD(double, camera_z, 0.7265, -10, 10, "m", "left camera in the IMU frame, up")               \
  FIELD(double, camera_tilt_x, -0.0068, -3.2, 3.2, "rad", "rotation vector, IMU axes; 0: straight ahead") \
  FIELD(double, camera_tilt_y, 0.0085, -3.2, 3.2, "rad", "as camera_tilt_x")                      \
  FIELD(double, camera_tilt_z, -0.0011, -3.2, 3.2, "rad", "as camera_tilt_x")                     \
  /* the tracks */                                                                                \
  FIELD(double, frame_rate, 10, 0.01, 1000, "Hz", "of the frames")                                \
  FIELD(int, features_per_frame, 70, 0, 1e5, "", "tracks that are kept up at a time")             \
  FIELD(double, track_life, 8, 0.01, 1e6, "s", "mean of a track's life, were its landmark always in view") \
  FIELD(int, shortest_track, 5, 1, 1e6, "frames", "a track starts only if its landmark stays in view for so long") \
  FIELD(double, image_border, 5, 0, 1e5, "px", "no feature nearer to the image's edge")           \
  FIELD(double, min_depth, 2.5, 0.1, 1e4, "m", "no feature nearer to the left camera")            \
  FIELD(double, max_depth, 60, 0.1, 1e4, "m", "no feature farther from the left camera")          \
  /* the errors of the velocities (defaults: as in the ECE276A 2020 recordings) */                \
  FIELD(int, velocities_per_frame, 1, 1, 1000, "", "body velocities a frame, at equal distances in time") \
  FIELD(double, linear_sigma, 0.5, 0, 100, "m/s", "white noise on each component, a sample")      \
  FIELD(double, angular_sigma, 0.05, 0, 100, "rad/s", "white noise on each component, a sample")  \
  FIELD(double, gyro_bias_x, 0.003, -10, 10, "rad/s", "constant error of the angular velocity")   \
  FIELD(double, gyro_bias_y, -0.004, -10, 10, "rad/s", "as gyro_bias_x")                          \
  FIELD(double, gyro_bias_z, 0.007, -10, 10, "rad/s", "as gyro_bias_x")                           \
  FIELD(double, velocity_scale, 1, 0.1, 10, "", "measured linear velocity over the true one")     \
  /* the errors of the features */                                                                \
  FIELD(double, pixel_sigma, 0.5, 0, 100, "px", "white noise on each of uL, vL, uR, vR")          \
  FIELD(double, disparity_sigma, 0, 0, 100, "px", "error of uL - uR that stays constant along a track") \
  FIELD(double, outlier_fraction, 0.02, 0, 1, "", "observations at random positions in the images") \
  FIELD(double, moving_fraction, 0, 0, 1, "", "tracks on objects that move along the street")      \
  FIELD(double, moving_speed, 6, 0, 100, "m/s", "of such objects")                                 \
  FIELD(double, dropped_fraction, 0, 0, 1, "", "frames without an observation; all tracks end there")
// clang-format on

/// A stereo-velocity run through a city's blocks, with its sensors and their errors. Every
/// combination that `validate` accepts can be simulated.
struct StreetSettings {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) type field = value;
  CHASLES_STREET_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
};

/// Calls visit(name, value, unit, doc, limits) for every setting, in the order of the list; `value`
/// is a reference to an int, double, std::uint64_t or std::string, const where `settings` is.
template <SettingsOf<StreetSettings> S, typename Visitor>
void for_each_setting(S& settings, Visitor&& visit) {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) \
  visit(#field, settings.field, unit, doc, limits::of<type>(least, most));
  CHASLES_STREET_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
}
#undef CHASLES_STREET_FIELDS

/// Throws UsageError with the field, its value and the expected one. Conditions on several fields
/// (a block too short to brake in) are checked by `make_street_path` and `make_street_drive`.
void validate(const StreetSettings& settings);

/// A named choice of settings.
struct StreetScene {
  std::string name;
  std::string doc;
  StreetSettings settings;
};

/// The scenes of the command line: the noisy default, one with the velocities of a GNSS/INS, and
/// one without any error.
const std::vector<StreetScene>& street_scenes();

/// The settings of a scene. Throws UsageError with the known names for an unknown one.
StreetSettings street_scene(const std::string& name);

}  // namespace chasles
