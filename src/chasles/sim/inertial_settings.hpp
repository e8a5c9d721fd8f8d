#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <chasles/base/settings.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

enum class Geometry { kHallway, kTurntable, kTrajectory, kWalk };

template <>
struct Choices<Geometry> {
  static constexpr std::array list{
      Choice{Geometry::kHallway, "hallway"}, Choice{Geometry::kTurntable, "turntable"},
      Choice{Geometry::kTrajectory, "trajectory"}, Choice{Geometry::kWalk, "walk"}};
};

/// Where the cameras of a rig look.
enum class RigLayout { kSideBySide, kBackToBack, kRing };

template <>
struct Choices<RigLayout> {
  static constexpr std::array list{Choice{RigLayout::kSideBySide, "side-by-side"},
                                   Choice{RigLayout::kBackToBack, "back-to-back"},
                                   Choice{RigLayout::kRing, "ring"}};
};

// The only list of settings: type, name, default, least, most, unit, meaning. It defines the
// struct, the command line, the help and the checks. Only numbers have a least and a most.
// clang-format off
#define CHASLES_INERTIAL_FIELDS(FIELD)                                                            \
  FIELD(std::string, name, "hallway", 0, 0, "", "name of the recording")                          \
  FIELD(Geometry, geometry, Geometry::kHallway, 0, 0, "", "hallway, turntable, trajectory, or walk")          \
  FIELD(std::uint64_t, seed, 1, 0, 0, "", "chooses the landmarks and, with the run, all noise")   \
  FIELD(double, knot_interval, 0.05, 1e-3, 10, "s", "of the spline that is the true motion")      \
  FIELD(double, rest_duration, 0, 0, 3600, "s", "standstill before the motion begins")               \
  FIELD(double, start_duration, 0, 0, 3600, "s", "from standstill to full speed; 0 without rest_duration: in motion from the first sample") \
  /* hallway: a walk along the centre of a corridor around a rectangular block, turning right */  \
  FIELD(double, hall_length, 30, 1, 1e4, "m", "of the centre line's rectangle")                   \
  FIELD(double, hall_width, 12, 1, 1e4, "m", "of the centre line's rectangle")                    \
  FIELD(double, corridor_width, 3, 0.5, 100, "m", "from wall to wall")                            \
  FIELD(double, corridor_height, 2.8, 0.5, 100, "m", "from floor to ceiling")                     \
  FIELD(double, imu_height, 1.2, 0, 100, "m", "above the floor")                                  \
  FIELD(int, sections, 4, 1, 1000, "", "straight sections that are walked, each with its turn")   \
  FIELD(double, walking_speed, 1.2, 0.05, 10, "m/s", "along the centre line")                     \
  FIELD(double, turn_duration, 1.3, 0.1, 100, "s", "of a turn of 90 degrees")                     \
  FIELD(double, step_rate, 2, 0.1, 10, "Hz", "of the walker's steps")                             \
  FIELD(double, bob_amplitude, 0.025, 0, 1, "m", "up and down with every step")                   \
  FIELD(double, sway_amplitude, 0.02, 0, 1, "m", "to the sides, with every second step")          \
  FIELD(double, roll_amplitude, 0.015, 0, 0.5, "rad", "about the forward axis, every second step")\
  FIELD(double, pitch_amplitude, 0.012, 0, 0.5, "rad", "about the left axis, every step")         \
  FIELD(double, yaw_amplitude, 0.03, 0, 0.5, "rad", "about the upward axis, every second step")   \
  FIELD(double, wall_density, 4, 0, 1000, "1/m^2", "landmarks on walls, floor and ceiling")     \
  /* walk: as hallway, but along two loops that share a hall, and in rooms of more shapes */     \
  FIELD(double, walk_duration, 0, 0, 1e5, "s", "of the walk with its standstill; 0: all sections")      \
  /* turntable: around a cube at the origin, looking at it */                                     \
  FIELD(double, circle_radius, 8, 0.1, 1e3, "m", "of the circle around the cube's centre")        \
  FIELD(double, revolutions, 2, 0.01, 1e3, "", "around the cube")                                 \
  FIELD(double, revolution_duration, 17.5, 0.5, 1e4, "s", "of one revolution")                    \
  FIELD(double, radial_sway, 0.6, 0, 100, "m", "towards the cube and away from it")               \
  FIELD(double, vertical_sway, 0.5, 0, 100, "m", "up and down")                                   \
  FIELD(double, gaze_sway, 0.03, 0, 0.5, "rad", "of the line of sight about the cube's centre")   \
  FIELD(double, cube_edge, 1.5, 0.01, 1e3, "m", "of the cube")                                      \
  FIELD(int, cube_landmarks, 40, 0, 100000, "", "on its faces")                                   \
  /* trajectory: landmarks are placed in front of the camera wherever it comes */                 \
  FIELD(int, visible_landmarks, 75, 0, 10000, "", "visible from each part of the path")   \
  FIELD(double, landmark_spacing, 0.5, 0.01, 100, "s", "between two searches for missing landmarks") \
  FIELD(double, landmark_nearest, 2, 0.1, 1e4, "m", "depth at which a landmark is placed, least") \
  FIELD(double, landmark_farthest, 10, 0.1, 1e4, "m", "depth at which a landmark is placed, most")\
  /* the cameras (defaults: as Kleinert & Stilla, half of 1398 x 1080 px at 28 Hz) */             \
  FIELD(int, cameras, 1, 1, 8, "", "of the rig")                                                  \
  FIELD(RigLayout, rig, RigLayout::kSideBySide, 0, 0, "", "side-by-side; back-to-back: every second camera looks backward; ring: turned by equal angles about the upward axis, to the left") \
  FIELD(double, baseline, 0.2, 1e-3, 10, "m", "between neighbours side by side")                  \
  FIELD(double, frame_rate, 28, 0.01, 1000, "Hz", "of the frames")                                \
  FIELD(double, focal_length, 480, 1, 1e5, "px", "fx = fy")                                       \
  FIELD(double, center_u, 349.5, -1e5, 1e5, "px", "principal point, to the right")                \
  FIELD(double, center_v, 270, -1e5, 1e5, "px", "principal point, down")                          \
  FIELD(int, image_width, 699, 1, 100000, "px", "of the images")                                  \
  FIELD(int, image_height, 540, 1, 100000, "px", "of the images")                                 \
  FIELD(double, camera_x, 0.05, -10, 10, "m", "first camera in the IMU frame, forward")           \
  FIELD(double, camera_y, 0.02, -10, 10, "m", "first camera in the IMU frame, to the left")       \
  FIELD(double, camera_z, 0.03, -10, 10, "m", "first camera in the IMU frame, up")                \
  FIELD(double, camera_tilt_x, 0, -3.2, 3.2, "rad", "rotation vector, IMU axes; 0: straight ahead") \
  FIELD(double, camera_tilt_y, 0, -3.2, 3.2, "rad", "as camera_tilt_x")                           \
  FIELD(double, camera_tilt_z, 0, -3.2, 3.2, "rad", "as camera_tilt_x")                           \
  FIELD(Distortion, distortion, Distortion::kNone, 0, 0, "", "of the lenses (docs/calibration-conventions.md)") \
  FIELD(double, distortion_1, 0, -100, 100, "", "first coefficient of the lens model, in its order") \
  FIELD(double, distortion_2, 0, -100, 100, "", "second coefficient of the lens model, in its order") \
  FIELD(double, distortion_3, 0, -100, 100, "", "third coefficient of the lens model, in its order") \
  FIELD(double, distortion_4, 0, -100, 100, "", "fourth coefficient of the lens model, in its order") \
  FIELD(double, distortion_5, 0, -100, 100, "", "fifth coefficient of the lens model, in its order") \
  FIELD(double, distortion_6, 0, -100, 100, "", "sixth coefficient of the lens model, in its order") \
  FIELD(double, distortion_7, 0, -100, 100, "", "seventh coefficient of the lens model, in its order") \
  FIELD(double, distortion_8, 0, -100, 100, "", "eighth coefficient of the lens model, in its order") \
  FIELD(double, distortion_9, 0, -100, 100, "", "ninth coefficient of the lens model, in its order") \
  FIELD(double, distortion_10, 0, -100, 100, "", "tenth coefficient of the lens model, in its order") \
  FIELD(double, distortion_11, 0, -100, 100, "", "eleventh coefficient of the lens model, in its order") \
  FIELD(double, distortion_12, 0, -100, 100, "", "twelfth coefficient of the lens model, in its order") \
  FIELD(double, readout_time, 0, 0, 0.2, "s", "of a rolling shutter, all lines; the time of an image is that of its first line; 0: a global shutter") \
  FIELD(ReadoutDirection, readout_direction, ReadoutDirection::kDown, 0, 0, "", "in which the lines are read: down, up, right or left") \
  /* the tracks */                                                                                \
  FIELD(int, landmarks_in_view, 35, 0, 100000, "", "tracks that are kept up at a time")           \
  FIELD(int, shortest_track, 5, 1, 100000, "frames", "no track begins whose landmark leaves the view sooner") \
  FIELD(double, image_border, 5, 0, 1e5, "px", "no landmark nearer to the image's edge")          \
  FIELD(double, min_range, 4, 0.1, 1e4, "m", "no landmark nearer to the camera")                \
  FIELD(double, max_range, 15, 0.1, 1e4, "m", "no landmark farther from the camera")              \
  FIELD(bool, occlusion, true, 0, 0, "", "walls and the cube hide what is behind them")           \
  FIELD(bool, keep_ids, false, 0, 0, "", "a landmark that returns keeps its number")              \
  /* the errors of the IMU (defaults: 7.5 mg a sample; 0.0056 deg/s/sqrt(Hz), 0.3 deg/s) */       \
  FIELD(double, imu_rate, 100, 1, 1e4, "Hz", "of the IMU's samples")                              \
  FIELD(ImuConvention, imu_convention, ImuConvention::kInstant, 0, 0, "", "meaning of a sample: instant, interval-mean or instant-force") \
  FIELD(double, accelerometer_noise_density, 0.007355, 0, 100, "m/s^2/sqrt(Hz)", "white noise")   \
  FIELD(double, gyroscope_noise_density, 9.774e-5, 0, 100, "rad/s/sqrt(Hz)", "white noise")       \
  FIELD(double, accelerometer_random_walk, 1e-4, 0, 100, "m/s^3/sqrt(Hz)", "of the bias")         \
  FIELD(double, gyroscope_random_walk, 1e-5, 0, 100, "rad/s^2/sqrt(Hz)", "of the bias")           \
  FIELD(double, accelerometer_bias_sigma, 0.02, 0, 100, "m/s^2", "of the bias at the beginning")  \
  FIELD(double, gyroscope_bias_sigma, 0.005236, 0, 10, "rad/s", "of the bias at the beginning")   \
  /* the errors of the images */                                                                  \
  FIELD(double, pixel_sigma, 1, 0, 100, "px", "white noise on each of u and v")                   \
  FIELD(double, track_drift, 0, 0, 100, "px/sqrt(s)", "random walk of u and of v along a track, alike in all cameras") \
  FIELD(double, match_sigma, 0, 0, 100, "px", "constant error of u and of v along a track, in the second camera") \
  FIELD(double, outlier_fraction, 0, 0, 1, "", "observations at random positions in the image")     \
  FIELD(double, dropped_fraction, 0, 0, 1, "", "frames without an observation; tracks continue after them") \
  /* rendered images (--images), in place of the tracks */                                        \
  FIELD(double, texel_size, 0.005, 1e-3, 1, "m", "of the surfaces' textures; larger where there are too many") \
  FIELD(double, texture_period, 0, 0, 1000, "m", "walls, floors and ceilings look alike, and repeat after this length: identical doors; 0: no two places look alike") \
  FIELD(double, texture_changed, 0, 0, 1, "", "share of every surface that looks otherwise than with 0, in strips of 1 to 3 m: a building that was redecorated in part") \
  FIELD(double, exposure, 1, 0.01, 100, "", "brightness of the images")                           \
  FIELD(double, exposure_drift, 0, 0, 3, "stops", "by which the brightness wanders, up and down") \
  FIELD(double, vignetting, 0, 0, 0.95, "", "light that the image's corners lack")                \
  FIELD(double, readout_noise, 1, 0, 100, "shades", "white noise of a pixel, of 256 shades")      \
  FIELD(double, photon_noise, 0.01, 0, 100, "shades", "variance of a pixel a shade of its brightness") \
  FIELD(double, exposure_time, 0, 0, 1, "s", "of each image, which blurs the motion; 0: an instant") \
  FIELD(int, blur_samples, 8, 2, 1000, "", "number of instants averaged in a blurred image")
// clang-format on

/// A motion of an IMU with cameras among landmarks, and the errors of the sensors. Every
/// combination that `validate` accepts can be simulated.
struct InertialSettings {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) type field = value;
  CHASLES_INERTIAL_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
};

/// Calls visit(name, value, unit, doc, limits) for every setting, in the order of the list; `value`
/// is a reference to a bool, int, double, std::uint64_t, std::string or enum, const where
/// `settings` is.
template <SettingsOf<InertialSettings> S, typename Visitor>
void for_each_setting(S& settings, Visitor&& visit) {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) \
  visit(#field, settings.field, unit, doc, limits::of<type>(least, most));
  CHASLES_INERTIAL_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
}
#undef CHASLES_INERTIAL_FIELDS

/// The coefficients of the lens model, as many as it has.
LensCoefficients lens_coefficients(const InertialSettings& settings);

/// Throws UsageError with the field, its value and the expected one. Conditions that depend on the
/// path (a corridor too narrow for its turns) are checked where the path is made.
void validate(const InertialSettings& settings);

/// A simulated scene: settings and, for the geometry `trajectory`, the motion.
struct InertialScene {
  std::string name;
  std::string doc;
  InertialSettings settings;
  Trajectory path = {};              ///< world_T_imu, z up; for the geometry `trajectory` only
  std::vector<Camera> cameras = {};  ///< instead of the settings' cameras, if any
  /// Real samples along the path, instead of simulated ones, if any.
  std::vector<ImuSample> imu = {};
  /// True biases of the real samples, where known; velocities are not used.
  std::vector<TrueMotion> imu_truth = {};
};

/// The scenes of the command line: `hallway` and `turntable` (Kleinert & Stilla, V-A), `walk` after
/// their indoor walk (V-B), and `trajectory`, which needs a path.
const std::vector<InertialScene>& inertial_scenes();

/// A scene by its name. Throws UsageError with the known names for an unknown one.
InertialScene inertial_scene(const std::string& name);

}  // namespace chasles
