#pragma once

#include <optional>
#include <string>

namespace chasles {

/// Everything that can be set about a run. An empty optional ("auto") is measured from the recording
/// (noise.hpp). The names, units and meanings below are the only list: for_each_setting feeds the
/// configuration files, --set, --help and summary.json.
struct Settings {
  std::string mode = "slam";
  std::string chart = "right-sen3";

  // Motion
  std::string velocity = "measured";
  std::string hold = "midpoint";
  std::optional<double> velocity_sigma;
  std::optional<double> rate_sigma;
  std::optional<double> velocity_walk;
  std::optional<double> rate_walk;
  double velocity_relative_sigma = 0.01;
  bool gyro_bias = true;
  std::optional<double> gyro_bias_sigma;
  double gyro_bias_walk = 1e-5;
  bool velocity_scale = false;
  double velocity_scale_sigma = 0.01;
  double velocity_scale_walk = 0;
  double initial_pose_sigma = 0;

  // Camera
  std::string stereo_rows = "mean";
  std::optional<double> pixel_sigma;
  std::optional<double> disparity_sigma;

  double disparity_inflation = 2;

  // Landmarks
  double gate = 0.85;
  double loose_gate = 0.98;
  int enough = 15;
  double min_disparity = 1;
  int waiting_landmarks = 24;
  bool update_with_first_observation = false;
  std::optional<double> initial_landmark_sigma;

  // Map
  bool compress_map = true;
};

/// Calls visit(name, value, unit or choices, meaning) for every setting, in order.
template <typename SettingsType, typename Visitor>
void for_each_setting(SettingsType& s, Visitor&& visit) {
  visit("mode", s.mode, "localize|map|slam", "which of the three tasks to do");
  visit("chart", s.chart, "standard|left-se3|right-se3|right-sen3", "error chart");
  visit("velocity", s.velocity, "measured|input",
        "body velocity: a measured state, or the input that is integrated");
  visit("hold", s.hold, "midpoint|zero-order", "an input velocity over its step");
  visit("velocity_sigma", s.velocity_sigma, "m/s", "white noise of a velocity sample");
  visit("rate_sigma", s.rate_sigma, "rad/s", "white noise of an angular velocity sample");
  visit("velocity_walk", s.velocity_walk, "m/s/sqrt(s)", "random walk of the true velocity");
  visit("rate_walk", s.rate_walk, "rad/s/sqrt(s)", "random walk of the true angular velocity");
  visit("velocity_relative_sigma", s.velocity_relative_sigma, "1",
        "further error of a velocity sample, as a part of the speed");
  visit("gyro_bias", s.gyro_bias, "bool", "estimate the bias of the angular velocity");
  visit("gyro_bias_sigma", s.gyro_bias_sigma, "rad/s", "initial uncertainty of that bias");
  visit("gyro_bias_walk", s.gyro_bias_walk, "rad/s/sqrt(s)", "random walk of that bias");
  visit("velocity_scale", s.velocity_scale, "bool", "estimate the scale of the velocity");
  visit("velocity_scale_sigma", s.velocity_scale_sigma, "1", "initial uncertainty of that scale");
  visit("velocity_scale_walk", s.velocity_scale_walk, "1/sqrt(s)", "random walk of that scale");
  visit("initial_pose_sigma", s.initial_pose_sigma, "rad, m", "initial uncertainty of the pose");
  visit("stereo_rows", s.stereo_rows, "all|mean+disparity|mean",
        "what of an observation updates the state; `mean` uses a disparity once, at the beginning");
  visit("pixel_sigma", s.pixel_sigma, "px", "noise of a pixel coordinate");
  visit("disparity_sigma", s.disparity_sigma, "px", "noise of a disparity");
  visit("disparity_inflation", s.disparity_inflation, "1",
        "of the disparity's noise in updates: its error hardly changes along a track");
  visit("gate", s.gate, "probability", "of a right observation to pass the gate; 1: no gate");
  visit("loose_gate", s.loose_gate, "probability", "gate where the other would leave too few");
  visit("enough", s.enough, "count", "observations that must pass the gate, else the loose one is used");
  visit("min_disparity", s.min_disparity, "px", "below it, no landmark is begun");
  visit("waiting_landmarks", s.waiting_landmarks, "count",
        "the state holds landmarks out of view up to this number in all");
  visit("update_with_first_observation", s.update_with_first_observation, "bool",
        "use the observation that began a landmark again for the update (as Du does)");
  visit("initial_landmark_sigma", s.initial_landmark_sigma, "m",
        "fixed and uncorrelated, instead of that of the observation (as Du has it)");
  visit("compress_map", s.compress_map, "bool",
        "false: one dense covariance over the whole map, whose cost grows with it");
}

}  // namespace chasles
