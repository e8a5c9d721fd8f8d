#pragma once

#include <numbers>
#include <optional>

#include <chasles/base/settings.hpp>

namespace chasles {

/// Settings of the initialisation of a visual-inertial run. As for InertialSlamSettings, the list
/// below defines files, --set, --help and summary.json.
struct InitialiserSettings {
  std::optional<double> heading = {};
  double heading_sigma = 0;
  double position_x = 0;
  double position_y = 0;
  double position_z = 0;
  double position_sigma = 0;
  bool in_map = false;

  double tilt_sigma = 0.2;
  double velocity_sigma = 2;
  double accelerometer_bias_sigma = 0.1;
  double gyroscope_bias_sigma = 0.1;
  double gravity = 9.80665;
  double inflation = 10;

  double static_window = 0.75;
  double static_noise_factor = 6;
  double static_displacement = 0.5;
  double static_velocity_sigma = 0.02;

  double min_window = 1;
  double min_stereo_window = 0.6;
  double max_window = 5;
  int attempt_frames = 5;
  int keyframes = 20;
  int max_tracks = 60;

  int min_tracks = 12;
  double min_parallax = 8;
  double min_parallax_angle = 0.015;
  double max_gravity_deviation = 1.5;
  double max_scale_sigma = 0.1;
  double least_velocity_sigma = 0.03;
  double max_tilt_sigma = 0.02;
  double max_misfit = 1.6;
  double min_inliers = 0.35;
};

/// A start is rejected if its bias is farther from 0 than this many standard deviations of the
/// prior. Static: the length of the bias; dynamic: each of its components.
inline constexpr double kBiasReach = 4;

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<InitialiserSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit(
      "heading", s.heading, "rad",
      "direction of the first camera's view at the first estimate, counter-clockwise from nav's x "
      "axis, such as from a compass (docs/initialisation.md); auto: nav's axes are those of the "
      "initialisation",
      limits::from_to(-2 * std::numbers::pi, 2 * std::numbers::pi));
  visit("heading_sigma", s.heading_sigma, "rad", "sigma of that heading; 0: it defines nav",
        limits::kNonNegative);
  visit("position_x", s.position_x, "m",
        "of the IMU at the first estimate, in nav, such as on a floor plan",
        limits::from_to(-1e6, 1e6));
  visit("position_y", s.position_y, "m", "as position_x", limits::from_to(-1e6, 1e6));
  visit("position_z", s.position_z, "m", "as position_x", limits::from_to(-1e6, 1e6));
  visit("position_sigma", s.position_sigma, "m", "sigma of that position; 0: it defines nav",
        limits::kNonNegative);
  visit("in_map", s.in_map, "bool",
        "heading and position are those in the map of an earlier run (docs/recognition.md): the "
        "run begins there, and does not search for its place",
        limits::kAny);
  visit("tilt_sigma", s.tilt_sigma, "rad", "upper limit of a start's sigma of roll and pitch",
        limits::kPositive);
  visit("velocity_sigma", s.velocity_sigma, "m/s", "upper limit of a start's sigma of the velocity",
        limits::kPositive);
  visit("accelerometer_bias_sigma", s.accelerometer_bias_sigma, "m/s^2",
        "sigma of the prior of that bias, mean 0", limits::kPositive);
  visit("gyroscope_bias_sigma", s.gyroscope_bias_sigma, "rad/s",
        "sigma of the prior of that bias, mean 0", limits::kPositive);
  visit("gravity", s.gravity, "m/s^2", "its magnitude", limits::kPositive);
  visit("inflation", s.inflation, "1",
        "dynamic initialisation: the information of the window's data is divided by this, because "
        "the filter uses them again",
        limits::at_least(1));
  visit("static_window", s.static_window, "s", "static initialisation: duration of the standstill",
        limits::kPositive);
  visit("static_noise_factor", s.static_noise_factor, "1",
        "static initialisation: the samples scatter by at most so many times the stated noise",
        limits::kPositive);
  visit("static_displacement", s.static_displacement, "px",
        "static initialisation: half of the tracks move by less than this, beyond their noise",
        limits::kPositive);
  visit("static_velocity_sigma", s.static_velocity_sigma, "m/s", "sigma of the velocity 0",
        limits::kPositive);
  visit("min_window", s.min_window, "s",
        "shortest window of a dynamic initialisation, with one camera", limits::kPositive);
  visit("min_stereo_window", s.min_stereo_window, "s",
        "the same where two cameras observe the same tracks", limits::kPositive);
  visit("max_window", s.max_window, "s", "longest window: older data are dropped",
        limits::kPositive);
  visit("attempt_frames", s.attempt_frames, "count", "a start is attempted at every n-th frame",
        limits::kPositive);
  visit("keyframes", s.keyframes, "count", "number of frames of the window that are used",
        limits::at_least(4));
  visit("max_tracks", s.max_tracks, "count", "maximum number that is used, those with most views",
        limits::kPositive);
  visit("min_tracks", s.min_tracks, "count", "minimum number that fits the motion",
        limits::kPositive);
  visit("min_parallax", s.min_parallax, "px", "median over the tracks, without the rotation",
        limits::kPositive);
  visit("min_parallax_angle", s.min_parallax_angle, "rad", "the same as an angle",
        limits::kPositive);
  visit("max_gravity_deviation", s.max_gravity_deviation, "m/s^2",
        "maximum error of gravity's magnitude, estimated without this constraint",
        limits::kPositive);
  visit("max_scale_sigma", s.max_scale_sigma, "1",
        "posterior sigma of the velocity, relative to the speed", limits::kPositive);
  visit("least_velocity_sigma", s.least_velocity_sigma, "m/s",
        "a sigma of the velocity that suffices at any speed", limits::kPositive);
  visit("max_tilt_sigma", s.max_tilt_sigma, "rad", "posterior sigma of roll and pitch",
        limits::kPositive);
  visit("max_misfit", s.max_misfit, "1", "squared residuals per degree of freedom",
        limits::kPositive);
  visit("min_inliers", s.min_inliers, "1", "fraction of the observations that fit the motion",
        limits::kPositive);
}

/// Throws UsageError with the setting's name ("start.keyframes"), its value and the expected one,
/// for a value out of its limits and for a window that is too short.
void validate(const InitialiserSettings& settings);

}  // namespace chasles
