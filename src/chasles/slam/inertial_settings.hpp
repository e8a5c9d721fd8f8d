#pragma once

#include <optional>
#include <string>

#include <chasles/base/settings.hpp>
#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/estimate/landmark_form.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/filter/depth_rule_names.hpp>
#include <chasles/loop/recognise.hpp>

namespace chasles {

enum class LandmarkInit { kMultiView, kFixedDepth };
enum class Toggle { kAuto, kTrue, kFalse };
/// What a filter does with a part of the calibration.
enum class Calibrate {
  kAuto,        ///< decided by for_images() and start_from_measured() (pipeline/), or false
  kFalse,       ///< it is known
  kTrue,        ///< it is estimated
  kConsidered,  ///< its uncertainty counts, and no update corrects it
};

template <>
struct Choices<LandmarkInit> {
  static constexpr std::array list{Choice{LandmarkInit::kMultiView, "multi-view"},
                                   Choice{LandmarkInit::kFixedDepth, "fixed-depth"}};
};

template <>
struct Choices<Toggle> {
  static constexpr std::array list{Choice{Toggle::kAuto, "auto"}, Choice{Toggle::kTrue, "true"},
                                   Choice{Toggle::kFalse, "false"}};
};

template <>
struct Choices<Calibrate> {
  static constexpr std::array list{
      Choice{Calibrate::kAuto, "auto"}, Choice{Calibrate::kFalse, "false"},
      Choice{Calibrate::kTrue, "true"}, Choice{Calibrate::kConsidered, "considered"}};
};

inline bool is_in_state(Calibrate c) {
  return c == Calibrate::kTrue || c == Calibrate::kConsidered;
}

/// An estimated time offset may decrease, so samples are kept for this long [s].
inline constexpr double kTimeOffsetReach = 0.2;

/// All settings of a visual-inertial filter. As for VelocitySlamSettings, the list below defines
/// files, --set, --help and summary.json. An empty optional is taken from the recording.
struct InertialSlamSettings {
  std::string chart = "right-sen3";
  LandmarkForm landmarks = LandmarkForm::kInverseDepth;
  LandmarkInit init = LandmarkInit::kMultiView;
  bool nav_attitude = false;
  double composition_interval = 0;
  Toggle first_estimates = Toggle::kAuto;
  bool first_order_transition = false;
  bool numeric_jacobians = false;
  Toggle keep_scale = Toggle::kAuto;

  std::optional<double> pixel_sigma;
  std::optional<double> track_sigma;
  std::optional<double> track_drift;
  std::optional<double> match_sigma;
  std::optional<double> imu_noise_scale;
  std::optional<double> vibration_noise;
  double initial_tilt_sigma = 0.002;
  double initial_velocity_sigma = 0.05;
  double initial_accelerometer_bias_sigma = 0.02;
  double initial_gyroscope_bias_sigma = 0.005236;

  /// `auto` is decided by decided() alone.
  bool keeps_exact_map() const { return exact_map == Toggle::kTrue; }

  /// The time offset that a run starts from [s]. `auto` is decided by start_from_measured()
  /// (pipeline/measured_offset.hpp) alone, and is 0 otherwise.
  double initial_time_offset() const { return time_offset.value_or(0); }

  /// First-estimates Jacobians. `auto`: where extrinsics, intrinsics or a readout are estimated.
  /// Their corrections move the linearisation points of the pixels in every chart
  /// (studies/cameras.md#calibration-in-the-state).
  bool uses_first_estimates() const {
    if (first_estimates != Toggle::kAuto) return first_estimates == Toggle::kTrue;
    return !first_order_transition &&
           (calibrate_extrinsics == Calibrate::kTrue || calibrate_intrinsics == Calibrate::kTrue ||
            calibrate_readout == Calibrate::kTrue);
  }

  /// Whether a part of the calibration is in the state. `auto` of the time offset is decided by
  /// for_images() and start_from_measured() (pipeline/) alone.
  bool has_time_offset() const { return is_in_state(calibrate_time_offset); }
  bool has_imu() const { return is_in_state(calibrate_imu); }
  bool has_extrinsics() const { return is_in_state(calibrate_extrinsics); }
  bool has_intrinsics() const {
    return is_in_state(calibrate_intrinsics) || is_in_state(calibrate_readout);
  }

  Calibrate calibrate_extrinsics = Calibrate::kFalse;
  double initial_extrinsic_rotation_sigma = 0.02;
  double initial_extrinsic_translation_sigma = 0.02;
  Calibrate calibrate_time_offset = Calibrate::kAuto;
  std::optional<double> time_offset;
  double initial_time_offset_sigma = 0.005;
  Calibrate calibrate_intrinsics = Calibrate::kFalse;
  double initial_focal_sigma = 0.004;
  double initial_principal_point_sigma = 3;
  double initial_distortion_sigma = 0.01;
  std::optional<double> readout_time;
  Calibrate calibrate_readout = Calibrate::kAuto;
  double initial_readout_sigma = 0.001;
  Calibrate calibrate_imu = Calibrate::kFalse;
  double initial_imu_scale_sigma = 0.005;
  double initial_imu_misalignment_sigma = 0.002;
  double initial_g_sensitivity_sigma = 0.0002;

  std::string depth_rule = "constant";
  double fixed_depth = 8;
  double fixed_depth_sigma = 3;
  double inverse_depth = 0.1;
  double inverse_depth_sigma = 0.5;
  std::optional<double> guessed_depth_observations;

  int clones = 15;
  int frames_per_clone = 4;
  double clone_interval = 0.2;
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
  Recognise recognise = Recognise::kNone;
  PriorMapUse prior_map = PriorMapUse::kEstimated;
  int recognisable = 1500;
  Toggle exact_map = Toggle::kAuto;
  double map_memory = 1000;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<InertialSlamSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("chart", s.chart, "choice", "error chart: coordinates of the error state (docs/charts.md)",
        limits::one_of(error_chart_names()));
  visit("landmarks", s.landmarks, "choice", "form of a landmark in the state", limits::kAny);
  visit("init", s.init, "choice",
        "landmark initialisation: delayed, after several clones have observed the point, or "
        "undelayed, at an assumed depth",
        limits::kAny);
  visit("nav_attitude", s.nav_attitude, "bool",
        "the world is the first IMU frame, and its attitude relative to gravity is estimated "
        "(K&S); false: the world's z axis points up",
        limits::kAny);
  visit("composition_interval", s.composition_interval, "s",
        "interval at which the world is moved to the IMU (needs nav_attitude); 0: never",
        limits::kNonNegative);
  visit(
      "first_estimates", s.first_estimates, "choice",
      "first-estimates Jacobians (for the chart standard); auto: where extrinsics, intrinsics or a "
      "readout are estimated",
      limits::kAny);
  visit(
      "first_order_transition", s.first_order_transition, "bool",
      "the covariance is propagated by I + F tau, in the chart's coordinates (K&S, eq. 14, 15; not "
      "with right-sen3); false: by the exact transition",
      limits::kAny);
  visit("numeric_jacobians", s.numeric_jacobians, "bool",
        "derivatives of a pixel by finite differences in the chart's coordinates (K&S, IV-C; for "
        "Cartesian landmarks of fixed-depth); false: analytic ones",
        limits::kAny);
  visit("keep_scale", s.keep_scale, "choice",
        "keeps the scale unobservable by pixels in the covariance (docs/filter.md; not with "
        "left-se3); auto: with the images of one camera",
        limits::kAny);
  visit("pixel_sigma", s.pixel_sigma, "px", "standard deviation of a pixel", limits::kPositive);
  visit("track_sigma", s.track_sigma, "px",
        "standard deviation of a pixel in updates, with errors that many tracks share "
        "(docs/noise.md); auto: with images 3, or 4 in batch and window, if no pixel_sigma is "
        "stated; else pixel_sigma",
        limits::kPositive);
  visit("track_drift", s.track_drift, "px/sqrt(s)",
        "density of the random walk by which a tracked point slides over its surface "
        "(docs/noise.md); the filter alone has it; auto: 2 with images, 0 with tracks",
        limits::kNonNegative);
  visit("match_sigma", s.match_sigma, "px",
        "constant error, along a track, of the matches in the cameras after the first "
        "(docs/noise.md); auto: 1 with images, 0 with tracks",
        limits::kNonNegative);
  visit("imu_noise_scale", s.imu_noise_scale, "1",
        "factor on the IMU's stated noise densities; auto: 3 with images, 1 with tracks and "
        "where the stated noise is exact",
        limits::kPositive);
  visit("vibration_noise", s.vibration_noise, "1",
        "factor on the variance that vibration and motion add to the IMU's stated noise "
        "(docs/noise.md); auto: 1 with images, 0 with tracks and where the stated noise is exact",
        limits::kNonNegative);
  visit("initial_tilt_sigma", s.initial_tilt_sigma, "rad", "initial sigma of roll and pitch",
        limits::kNonNegative);
  visit("initial_velocity_sigma", s.initial_velocity_sigma, "m/s", "initial sigma of the velocity",
        limits::kNonNegative);
  visit("initial_accelerometer_bias_sigma", s.initial_accelerometer_bias_sigma, "m/s^2",
        "initial sigma of that bias", limits::kNonNegative);
  visit("initial_gyroscope_bias_sigma", s.initial_gyroscope_bias_sigma, "rad/s",
        "initial sigma of that bias", limits::kNonNegative);
  visit("calibrate_extrinsics", s.calibrate_extrinsics, "choice",
        "estimate the extrinsics of each camera, starting from the recording's calibration; "
        "considered: only count their uncertainty; auto: false",
        limits::kAny);
  visit("initial_extrinsic_rotation_sigma", s.initial_extrinsic_rotation_sigma, "rad",
        "initial sigma of the rotation about each axis", limits::kNonNegative);
  visit("initial_extrinsic_translation_sigma", s.initial_extrinsic_translation_sigma, "m",
        "initial sigma of the translation along each axis", limits::kNonNegative);
  visit("calibrate_time_offset", s.calibrate_time_offset, "choice",
        "estimate the cameras' time offset, starting from time_offset; considered: only count its "
        "uncertainty; auto: the filter estimates it with images",
        limits::kAny);
  visit("time_offset", s.time_offset, "s",
        "added to the time of an image to get the IMU's time (Kalibr: timeshift_cam_imu); auto: 0, "
        "or what the tracks of a recording show, where that is beyond 10 ms",
        limits::kClockOffset);
  visit("initial_time_offset_sigma", s.initial_time_offset_sigma, "s",
        "initial sigma of the time offset", limits::kNonNegative);
  visit("calibrate_intrinsics", s.calibrate_intrinsics, "choice",
        "calibrate_extrinsics for focal lengths, principal point and lens of each camera; auto: "
        "false",
        limits::kAny);
  visit("initial_focal_sigma", s.initial_focal_sigma, "1",
        "initial sigma of a focal length, over itself", limits::kPositive);
  visit("initial_principal_point_sigma", s.initial_principal_point_sigma, "px",
        "initial sigma of each coordinate of the principal point", limits::kPositive);
  visit(
      "initial_distortion_sigma", s.initial_distortion_sigma, "1",
      "initial sigma of each coefficient of the lens model; of tangential and prism terms a tenth",
      limits::kPositive);
  visit("readout_time", s.readout_time, "s",
        "of a rolling shutter, all lines (docs/inertial.md); 0: a global one; below 0: upwards; "
        "auto: as the recording states it, or else as its images show it",
        limits::from_to(-kLongestReadout, kLongestReadout));
  visit("calibrate_readout", s.calibrate_readout, "choice",
        "calibrate_intrinsics for the readout time of each rolling shutter; auto: if a run "
        "measures it "
        "beforehand",
        limits::kAny);
  visit("initial_readout_sigma", s.initial_readout_sigma, "s", "initial sigma of a readout time",
        limits::kPositive);
  visit("calibrate_imu", s.calibrate_imu, "choice",
        "calibrate_extrinsics for scales, misalignments and g-sensitivity of the IMU, on top of "
        "its stated intrinsics; auto: false",
        limits::kAny);
  visit("initial_imu_scale_sigma", s.initial_imu_scale_sigma, "1",
        "initial sigma of the scale of each axis of accelerometer and gyroscope; 0: known",
        limits::kNonNegative);
  visit("initial_imu_misalignment_sigma", s.initial_imu_misalignment_sigma, "rad",
        "initial sigma of each angle by which these axes are misaligned; 0: known",
        limits::kNonNegative);
  visit("initial_g_sensitivity_sigma", s.initial_g_sensitivity_sigma, "rad/s/(m/s^2)",
        "initial sigma of what a specific force along each axis adds to each angular rate; 0: none",
        limits::kNonNegative);
  visit("depth_rule", s.depth_rule, "choice",
        "depth of an undelayed landmark initialisation: constant, as the next settings have it, or "
        "a rule that the program has registered (docs/python.md)",
        limits::one_of(depth_rule_names()));
  visit("fixed_depth", s.fixed_depth, "m",
        "assumed depth of an undelayed landmark initialisation (K&S: 8)", limits::kPositive);
  visit("fixed_depth_sigma", s.fixed_depth_sigma, "m", "sigma of that depth, along the ray",
        limits::kPositive);
  visit("inverse_depth", s.inverse_depth, "1/m",
        "assumed inverse depth of an undelayed landmark initialisation", limits::kPositive);
  visit("inverse_depth_sigma", s.inverse_depth_sigma, "1/m", "sigma of that inverse depth",
        limits::kPositive);
  visit("guessed_depth_observations", s.guessed_depth_observations, "count",
        "the product of the errors of an assumed depth and of the motion adds to the pixel noise, "
        "times the number of observations, up to this number; 0: not at all; auto: 20 in a filter "
        "with images, else 0",
        limits::kNonNegative);
  visit("clones", s.clones, "count", "maximum number of clones for delayed landmark initialisation",
        limits::kNonNegative);
  visit("frames_per_clone", s.frames_per_clone, "count", "every n-th frame's pose becomes a clone",
        limits::at_least(1));
  visit("clone_interval", s.clone_interval, "s",
        "and the pose of the first frame after this time, where frames are rarer or have no image",
        limits::kPositive);
  visit("max_relative_depth_sigma", s.max_relative_depth_sigma, "1",
        "a track becomes a landmark when its pixels determine the relative depth to this sigma",
        limits::kNonNegative);
  visit("max_total_depth_sigma", s.max_total_depth_sigma, "1",
        "and when the relative depth has this sigma with the uncertainty of the poses",
        limits::kNonNegative);
  visit("min_parallax", s.min_parallax, "rad", "and when its rays differ by this angle (parallax)",
        limits::kNonNegative);
  visit("min_landmarks", s.min_landmarks, "count",
        "while the state has fewer, landmarks are initialised without delay, in anchored inverse "
        "depth",
        limits::kNonNegative);
  visit("settled_depth_sigma", s.settled_depth_sigma, "1",
        "an anchored landmark becomes Cartesian when its relative depth has this sigma; 0: never",
        limits::kNonNegative);
  visit("zupt_velocity_sigma", s.zupt_velocity_sigma, "m/s",
        "sigma of the velocity in a zero-velocity update, for one second of standstill; 0: no "
        "zero-velocity updates",
        limits::kNonNegative);
  visit("noise_inflation", s.noise_inflation, "1",
        "measurement noise inflation: a young landmark's pixel noise is multiplied by 1 + "
        "noise_inflation, decreasing to 1 over noise_inflation_frames",
        limits::kNonNegative);
  visit("noise_inflation_frames", s.noise_inflation_frames, "count", "see noise_inflation",
        limits::at_least(1));
  visit("gate", s.gate, "probability", "of a correct observation to pass the gate; 1: no gate",
        limits::kProbability);
  visit("max_rejections", s.max_rejections, "count",
        "a landmark that the gate rejects so often in a row is retired", limits::kNonNegative);
  visit(
      "max_landmarks", s.max_landmarks, "count",
      "maximum number in the state; below 4, with as few min_landmarks: mainly null-space updates",
      limits::kNonNegative);
  visit("waiting_frames", s.waiting_frames, "count",
        "a landmark out of view stays in the state for so many frames", limits::kNonNegative);
  visit("recognise", s.recognise, "choice",
        "landmarks that come into view again return into the state with their exact covariance, "
        "which closes loops (docs/recognition.md): none, those whose ids the tracks have again, or "
        "those that look the same in the images of the first camera",
        limits::kAny);
  visit(
      "prior_map", s.prior_map, "choice",
      "a map of an earlier run (--map) is estimated further, or considered: no update changes it, "
      "while its uncertainty counts as before (Schmidt-Kalman filter, docs/recognition.md)",
      limits::kAny);
  visit("recognisable", s.recognisable, "count",
        "recognise: most landmarks out of the state that may be recognised by their appearance; "
        "beyond, they are thinned out",
        limits::at_least(1));
  visit("exact_map", s.exact_map, "choice",
        "landmarks out of the state and the poses of the past are estimated given all measurements "
        "(docs/map.md); false: landmarks keep their last estimate, and there is no smoothed path; "
        "auto: a filter does so for a recording",
        limits::kAny);
  visit("map_memory", s.map_memory, "MB",
        "exact_map: bound on the memory; beyond it the oldest landmarks and poses are final; 0: no "
        "bound",
        limits::kNonNegative);
}

/// Throws UsageError with the setting's name, its value and the expected one, for a value out of
/// its limits and for settings that exclude each other.
void validate(const InertialSlamSettings& settings);

}  // namespace chasles
