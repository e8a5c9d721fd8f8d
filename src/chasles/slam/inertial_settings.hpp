#pragma once

#include <optional>
#include <string>

#include <chasles/settings.hpp>

namespace chasles {

/// An estimated time offset may yet be set back: samples are kept for so long [s].
inline constexpr double kTimeOffsetReach = 0.2;

/// Everything that can be set about a run with an IMU. As VelocitySlamSettings: the list below
/// feeds files,
/// --set, --help and summary.json; an empty optional is taken from the recording.
struct InertialSlamSettings {
  std::string chart = "right-sen3";
  std::string landmarks = "inverse-depth";
  std::string init = "multi-view";
  bool nav_attitude = false;
  double composition_interval = 0;
  bool first_estimates = false;
  std::string keep_scale = "auto";

  std::optional<double> pixel_sigma;
  double imu_noise_scale = 1;
  double initial_tilt_sigma = 0.002;
  double initial_velocity_sigma = 0.05;
  double initial_accelerometer_bias_sigma = 0.02;
  double initial_gyroscope_bias_sigma = 0.005236;

  bool calibrate_extrinsics = false;
  double initial_extrinsic_rotation_sigma = 0.02;
  double initial_extrinsic_translation_sigma = 0.02;
  bool calibrate_time_offset = false;
  double time_offset = 0;
  double initial_time_offset_sigma = 0.01;

  double fixed_depth = 8;
  double fixed_depth_sigma = 3;
  double inverse_depth = 0.1;
  double inverse_depth_sigma = 0.5;
  int guessed_depth_observations = 0;

  int clones = 15;
  int frames_per_clone = 4;
  double max_relative_depth_sigma = 0.2;
  double max_total_depth_sigma = 0.3;
  double min_parallax = 0.02;
  int min_landmarks = 12;
  double settled_depth_sigma = 0.03;

  double zupt_velocity_sigma = 0.01;

  double noise_inflation = 0;
  int noise_inflation_frames = 20;

  double gate = 0.999;
  int max_rejections = 5;
  int max_landmarks = 50;
  int waiting_frames = 0;
};

/// Calls visit(name, value, unit or choices, meaning) for every setting, in order.
template <SettingsOf<InertialSlamSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("chart", s.chart, "standard|left-se3|right-se3|right-sen3",
        "what the numbers of the error mean (docs/charts.md)");
  visit("landmarks", s.landmarks, "cartesian|inverse-depth", "form of a landmark in the state");
  visit("init", s.init, "multi-view|fixed-depth",
        "a landmark begins when several poses have seen it well, or at once, at a guessed depth");
  visit("nav_attitude", s.nav_attitude, "bool",
        "the world is the first IMU frame, and its attitude against gravity is estimated (K&S); "
        "false: the world's z axis points up");
  visit("composition_interval", s.composition_interval, "s",
        "the world is moved to the IMU so often (needs nav_attitude); 0: never");
  visit("first_estimates", s.first_estimates, "bool",
        "linearise at first estimates instead of the present ones (for the chart standard)");
  visit("keep_scale", s.keep_scale, "auto|true|false",
        "the covariance follows the direction of scale, so that pixels do not seem to tell it "
        "(docs/filter.md; not with left-se3); auto: with the images of one camera");
  visit("pixel_sigma", s.pixel_sigma, "px", "noise of a pixel");
  visit("imu_noise_scale", s.imu_noise_scale, "1", "factor on the IMU's stated noise densities");
  visit("initial_tilt_sigma", s.initial_tilt_sigma, "rad", "initial uncertainty of roll and pitch");
  visit("initial_velocity_sigma", s.initial_velocity_sigma, "m/s",
        "initial uncertainty of the velocity");
  visit("initial_accelerometer_bias_sigma", s.initial_accelerometer_bias_sigma, "m/s^2",
        "initial uncertainty of that bias");
  visit("initial_gyroscope_bias_sigma", s.initial_gyroscope_bias_sigma, "rad/s",
        "initial uncertainty of that bias");
  visit("calibrate_extrinsics", s.calibrate_extrinsics, "bool",
        "estimate where each camera is on the IMU, beginning with the recording's calibration");
  visit("initial_extrinsic_rotation_sigma", s.initial_extrinsic_rotation_sigma, "rad",
        "how far that is wrong, about each axis");
  visit("initial_extrinsic_translation_sigma", s.initial_extrinsic_translation_sigma, "m",
        "the same along each axis");
  visit("calibrate_time_offset", s.calibrate_time_offset, "bool",
        "estimate the cameras' time offset, beginning with time_offset");
  visit("time_offset", s.time_offset, "s",
        "to be added to the time of an image to have that of the IMU's clock (Kalibr's "
        "timeshift_cam_imu)");
  visit("initial_time_offset_sigma", s.initial_time_offset_sigma, "s", "how far that is wrong");
  visit("fixed_depth", s.fixed_depth, "m", "where a landmark begins that begins at once (K&S: 8)");
  visit("fixed_depth_sigma", s.fixed_depth_sigma, "m", "its uncertainty along the ray");
  visit("inverse_depth", s.inverse_depth, "1/m", "the same for inverse depth");
  visit("inverse_depth_sigma", s.inverse_depth_sigma, "1/m", "its uncertainty");
  visit("guessed_depth_observations", s.guessed_depth_observations, "count",
        "the error of a guessed depth times that of the way counts as noise, as often as the "
        "landmark was seen, up to so many times; 0: not at all");
  visit("clones", s.clones, "count", "past poses that are kept for multi-view beginnings");
  visit("frames_per_clone", s.frames_per_clone, "count", "every n-th frame's pose is kept");
  visit("max_relative_depth_sigma", s.max_relative_depth_sigma, "1",
        "a track becomes a landmark when its pixels tell the depth that well");
  visit("max_total_depth_sigma", s.max_total_depth_sigma, "1",
        "and when, with the uncertainty of the poses, the depth is known that well");
  visit("min_parallax", s.min_parallax, "rad", "and when its rays differ by this angle");
  visit("min_landmarks", s.min_landmarks, "count",
        "while the state has fewer, tracks begin at once, in anchored inverse depth");
  visit(
      "settled_depth_sigma", s.settled_depth_sigma, "1",
      "an anchored landmark becomes Cartesian when its relative depth is known so well; 0: never");
  visit("zupt_velocity_sigma", s.zupt_velocity_sigma, "m/s",
        "what one second of standing still tells of the velocity; 0: standing still is not used");
  visit("noise_inflation", s.noise_inflation, "1",
        "a young landmark's pixel noise is larger by 1 + noise_inflation, falling to 1 over "
        "noise_inflation_frames");
  visit("noise_inflation_frames", s.noise_inflation_frames, "count", "see noise_inflation");
  visit("gate", s.gate, "probability", "of a right observation to pass the gate; 1: no gate");
  visit("max_rejections", s.max_rejections, "count",
        "a landmark refused by the gate so often in a row leaves the state");
  visit("max_landmarks", s.max_landmarks, "count",
        "in the state; fewer than 4, with as few min_landmarks: the filter lives on tracks");
  visit("waiting_frames", s.waiting_frames, "count",
        "a landmark out of view waits in the state for so many frames");
}

}  // namespace chasles
