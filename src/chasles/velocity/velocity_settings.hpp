#pragma once

#include <optional>
#include <string>

#include <chasles/base/settings.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/velocity/stereo_rows.hpp>

namespace chasles {

enum class SlamMode { kLocalize, kMap, kSlam };
enum class VelocityRole { kMeasured, kInput };
enum class VelocityHold { kMidpoint, kZeroOrder };
enum class VelocityAxes { kAuto, kImu, kLevel };

template <>
struct Choices<SlamMode> {
  static constexpr std::array list{Choice{SlamMode::kLocalize, "localize"},
                                   Choice{SlamMode::kMap, "map"}, Choice{SlamMode::kSlam, "slam"}};
};

template <>
struct Choices<VelocityRole> {
  static constexpr std::array list{Choice{VelocityRole::kMeasured, "measured"},
                                   Choice{VelocityRole::kInput, "input"}};
};

template <>
struct Choices<VelocityHold> {
  static constexpr std::array list{Choice{VelocityHold::kMidpoint, "midpoint"},
                                   Choice{VelocityHold::kZeroOrder, "zero-order"}};
};

template <>
struct Choices<VelocityAxes> {
  static constexpr std::array list{Choice{VelocityAxes::kAuto, "auto"},
                                   Choice{VelocityAxes::kImu, "imu"},
                                   Choice{VelocityAxes::kLevel, "level"}};
};

/// All settings of a stereo-velocity filter. An empty optional ("auto") is taken from the recording
/// (velocity_noise.hpp). for_each_setting is the only list of units, choices and meanings. It
/// defines the configuration files, --set, --help and summary.json.
struct VelocitySlamSettings {
  SlamMode mode = SlamMode::kSlam;
  std::string chart = "right-sen3";

  VelocityRole velocity = VelocityRole::kMeasured;
  VelocityHold hold = VelocityHold::kMidpoint;
  std::optional<double> velocity_sigma;
  std::optional<double> rate_sigma;
  double velocity_relative_sigma = 0.004;
  std::optional<double> velocity_walk;
  std::optional<double> rate_walk;
  bool gyro_bias = true;
  std::optional<double> gyro_bias_sigma;
  std::optional<double> gyro_bias_walk;
  bool velocity_scale = false;
  double velocity_scale_sigma = 0.01;
  double velocity_scale_walk = 0;
  VelocityAxes velocity_axes = VelocityAxes::kAuto;
  std::optional<double> time_offset = 0;
  double tilt_sigma = 0.05;
  double tilt_walk = 0.001;
  double velocity_heading_sigma = 0.0005;
  double velocity_heading_walk = 0;
  double initial_pose_sigma = 0;

  StereoRows stereo_rows = StereoRows::kMean;
  std::optional<double> pixel_sigma;
  std::optional<double> disparity_sigma;
  std::optional<double> disparity_inflation;

  double gate = 0.8;
  double loose_gate = 0.99;
  int gate_quorum = 15;
  int updates_per_frame = 20;
  double min_disparity = 1;
  int waiting_landmarks = 24;
  bool update_with_first_observation = false;
  std::optional<double> initial_landmark_sigma;

  bool compress_map = true;
  double map_memory = 0;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<VelocitySlamSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("mode", s.mode, "choice",
        "predict only; map along the predicted trajectory, taken as true; or both jointly",
        limits::kAny);
  visit("chart", s.chart, "choice", "error chart: coordinates of the error state (docs/charts.md)",
        limits::one_of(error_chart_names()));

  visit("velocity", s.velocity, "choice",
        "a body velocity measures a velocity in the state, or is the input that is integrated",
        limits::kAny);
  visit("hold", s.hold, "choice",
        "an input velocity over its step: mean of both ends, or the first", limits::kAny);
  visit("velocity_sigma", s.velocity_sigma, "m/s", "white noise (sigma) of a velocity sample",
        limits::kNonNegative);
  visit("rate_sigma", s.rate_sigma, "rad/s", "white noise (sigma) of an angular velocity sample",
        limits::kNonNegative);
  visit("velocity_relative_sigma", s.velocity_relative_sigma, "1",
        "additional sigma of a velocity sample, relative to the speed", limits::kNonNegative);
  visit("velocity_walk", s.velocity_walk, "m/s/sqrt(s)", "random walk of the true velocity",
        limits::kNonNegative);
  visit("rate_walk", s.rate_walk, "rad/s/sqrt(s)", "random walk of the true angular velocity",
        limits::kNonNegative);
  visit("gyro_bias", s.gyro_bias, "bool", "estimate the bias of the angular velocity",
        limits::kAny);
  visit("gyro_bias_sigma", s.gyro_bias_sigma, "rad/s", "initial sigma of that bias",
        limits::kNonNegative);
  visit("gyro_bias_walk", s.gyro_bias_walk, "rad/s/sqrt(s)", "random walk of that bias",
        limits::kNonNegative);
  visit("velocity_scale", s.velocity_scale, "bool", "estimate the scale of the velocity",
        limits::kAny);
  visit("velocity_scale_sigma", s.velocity_scale_sigma, "1", "initial sigma of that scale",
        limits::kNonNegative);
  visit("velocity_scale_walk", s.velocity_scale_walk, "1/sqrt(s)", "random walk of that scale",
        limits::kNonNegative);
  visit("velocity_axes", s.velocity_axes, "choice",
        "axes of the velocities: the IMU's, or level ones with its heading; auto: from their "
        "vertical components (docs/noise.md)",
        limits::kAny);
  visit("time_offset", s.time_offset, "s",
        "frames' clock + time_offset = velocities' clock: above 0 where velocities are stamped "
        "late; auto: estimated from the tracks (docs/noise.md)",
        limits::kClockOffset);
  visit("tilt_sigma", s.tilt_sigma, "rad",
        "initial sigma of the IMU's tilt, where velocities are along level axes",
        limits::kNonNegative);
  visit("tilt_walk", s.tilt_walk, "rad/sqrt(s)", "random walk of that", limits::kNonNegative);
  visit("velocity_heading_sigma", s.velocity_heading_sigma, "rad",
        "initial sigma of the heading of level axes relative to the IMU's", limits::kNonNegative);
  visit("velocity_heading_walk", s.velocity_heading_walk, "rad/sqrt(s)", "random walk of that",
        limits::kNonNegative);
  visit("initial_pose_sigma", s.initial_pose_sigma, "rad, m",
        "initial sigma of the pose; 0: the world is the first pose", limits::kNonNegative);

  visit("stereo_rows", s.stereo_rows, "choice",
        "rows of (uL, vL, uR, vR) that update the state: all four, means and disparity, or means",
        limits::kAny);
  visit("pixel_sigma", s.pixel_sigma, "px",
        "sigma of a row (uL + uR)/2, (vL + vR)/2, or of each pixel where all four are used",
        limits::kPositive);
  visit("disparity_sigma", s.disparity_sigma, "px", "sigma of a disparity", limits::kPositive);
  visit("disparity_inflation", s.disparity_inflation, "1",
        "factor on that sigma in updates, because a disparity's error hardly changes along a track",
        limits::kNonNegative);

  visit("gate", s.gate, "probability", "of a correct observation to pass the gate; 1: no gate",
        limits::kProbability);
  visit("loose_gate", s.loose_gate, "probability",
        "gate of a frame in which fewer than gate_quorum observations pass `gate`",
        limits::kProbability);
  visit("gate_quorum", s.gate_quorum, "count", "see loose_gate", limits::kNonNegative);
  visit("updates_per_frame", s.updates_per_frame, "count",
        "maximum number of observations that update the state, longest unused landmarks first; 0: "
        "all",
        limits::kNonNegative);
  visit("min_disparity", s.min_disparity, "px", "no landmark is initialised below it",
        limits::kNonNegative);
  visit("waiting_landmarks", s.waiting_landmarks, "count",
        "landmarks out of view stay in the state while it has fewer in all", limits::kNonNegative);
  visit(
      "update_with_first_observation", s.update_with_first_observation, "bool",
      "use the observation that initialises a landmark for an update as well (Du; counts it twice)",
      limits::kAny);
  visit("initial_landmark_sigma", s.initial_landmark_sigma, "m",
        "fixed and uncorrelated (Du); auto: from the observation and the pose",
        limits::kNonNegative);

  visit("compress_map", s.compress_map, "bool",
        "false: one dense covariance over the whole map, whose cost grows with it", limits::kAny);
  visit("map_memory", s.map_memory, "MB",
        "memory of the steps by which later measurements correct landmarks out of view; beyond it "
        "the oldest landmarks are final; 0: no bound (docs/map.md)",
        limits::from_to(0.0, 1e9));
}

/// Throws UsageError with the setting's name, its value and the expected one, for a value out of
/// its limits and for level axes that the mode does not estimate.
void validate(const VelocitySlamSettings& settings);

}  // namespace chasles
