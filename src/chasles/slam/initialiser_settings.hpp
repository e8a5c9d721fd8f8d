#pragma once

#include <chasles/settings.hpp>

namespace chasles {

/// When an inertial run may begin. As InertialSlamSettings: the list below feeds files, --set,
/// --help and summary.json.
struct InitialiserSettings {
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
  double max_window = 3;
  int attempt_frames = 5;
  int keyframes = 12;
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

/// A start whose bias is more deviations of its prior from 0 is not believed: at rest a bias's
/// length, in motion each of its components.
inline constexpr double kBiasReach = 4;

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<InitialiserSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("tilt_sigma", s.tilt_sigma, "rad", "a start's roll and pitch are never less certain",
        limits::kPositive);
  visit("velocity_sigma", s.velocity_sigma, "m/s", "a start's velocity is never less certain",
        limits::kPositive);
  visit("accelerometer_bias_sigma", s.accelerometer_bias_sigma, "m/s^2",
        "what is known of that bias beforehand, about 0", limits::kPositive);
  visit("gyroscope_bias_sigma", s.gyroscope_bias_sigma, "rad/s",
        "what is known of that bias beforehand, about 0", limits::kPositive);
  visit("gravity", s.gravity, "m/s^2", "its magnitude", limits::kPositive);
  visit("inflation", s.inflation, "1",
        "a start in motion counts its window's data so many times less, for the filter uses them",
        limits::at_least(1));
  visit("static_window", s.static_window, "s", "at rest for so long: a start at rest",
        limits::kPositive);
  visit("static_noise_factor", s.static_noise_factor, "1",
        "at rest the samples deviate by at most so many times the stated noise", limits::kPositive);
  visit("static_displacement", s.static_displacement, "px",
        "and half of the tracks move by less than this, beyond noise", limits::kPositive);
  visit("static_velocity_sigma", s.static_velocity_sigma, "m/s", "uncertainty of the velocity 0",
        limits::kPositive);
  visit("min_window", s.min_window, "s", "a start in motion needs so much, with one camera",
        limits::kPositive);
  visit("min_stereo_window", s.min_stereo_window, "s", "and so much where two see the same tracks",
        limits::kPositive);
  visit("max_window", s.max_window, "s", "older data are given up", limits::kPositive);
  visit("attempt_frames", s.attempt_frames, "count", "a start is tried at every n-th frame",
        limits::kPositive);
  visit("keyframes", s.keyframes, "count", "frames of the window that are used",
        limits::at_least(4));
  visit("max_tracks", s.max_tracks, "count", "that are used, the best covered ones",
        limits::kPositive);
  visit("min_tracks", s.min_tracks, "count", "that fit the motion", limits::kPositive);
  visit("min_parallax", s.min_parallax, "px", "median over the tracks, rotation taken away",
        limits::kPositive);
  visit("min_parallax_angle", s.min_parallax_angle, "rad", "the same as an angle",
        limits::kPositive);
  visit("max_gravity_deviation", s.max_gravity_deviation, "m/s^2",
        "of gravity's magnitude, estimated without knowing it", limits::kPositive);
  visit("max_scale_sigma", s.max_scale_sigma, "1",
        "the velocity's posterior deviation, as a share of the speed", limits::kPositive);
  visit("least_velocity_sigma", s.least_velocity_sigma, "m/s",
        "a deviation that is good enough at any speed", limits::kPositive);
  visit("max_tilt_sigma", s.max_tilt_sigma, "rad", "posterior deviation of roll and pitch",
        limits::kPositive);
  visit("max_misfit", s.max_misfit, "1", "squared residuals per degree of freedom",
        limits::kPositive);
  visit("min_inliers", s.min_inliers, "1", "share of the observations that fit the motion",
        limits::kPositive);
}

/// Throws UsageError with the setting's name, its value and what is expected: for one out of its
/// limits ("start.keyframes"), and for a window that is too short.
void validate(const InitialiserSettings& settings);

}  // namespace chasles
