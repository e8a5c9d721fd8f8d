#include "inertial_setup.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/imu_range.hpp>
#include <chasles/error.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>

#include "calibration_report.hpp"
#include "frame_state.hpp"

namespace chasles::app {
namespace {

// The truth as it is: nothing is drawn.
InertialStart true_start(const Recording& recording) {
  if (recording.truth.empty()) {
    throw Error(
        ExitCode::kNotInitialised,
        fmt::format("{}: has no truth to begin at (--truth FILE gives one); without --begin "
                    "truth the start is found by itself",
                    recording.name));
  }
  InertialSlamSettings exact;
  exact.initial_tilt_sigma = 0;
  exact.initial_velocity_sigma = 0;
  return draw_start(recording, exact, 0, 0);
}

ImuNoise noise_of(const Recording& recording) {
  if (recording.imu_noise) return *recording.imu_noise;
  throw InputError(
      fmt::format("{}: states no IMU noise: write accelerometer_noise_density, "
                  "accelerometer_random_walk, gyroscope_noise_density and "
                  "gyroscope_random_walk into its calibration",
                  recording.name));
}

std::vector<std::string> extra_names(const InertialSlamSettings& settings, std::size_t cameras) {
  std::vector<std::string> names;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
  }
  for (std::string& name : calibration_columns(settings, cameras)) names.push_back(std::move(name));
  return names;
}

}  // namespace

RunState run_state(const InertialEstimate& e, std::span<const Camera> cameras,
                   double milliseconds) {
  RunState state = frame_state(e, milliseconds);
  state.world_T_imu = e.motion.nav_T_imu;
  state.pose_covariance = e.motion.covariance.topLeftCorner<6, 6>();
  state.extra = {e.motion.v_nav.begin(), e.motion.v_nav.end()};
  state.extra.insert(state.extra.end(), e.motion.biases.begin(), e.motion.biases.end());
  for (int row = 6; row < 15; ++row) {
    state.extra_sigma.push_back(std::sqrt(e.motion.covariance(row, row)));
  }
  if (e.calibration) append_calibration(*e.calibration, cameras, state);
  return state;
}

ImuBuffer::Options imu_options(const Recording& recording) {
  ImuBuffer::Options options{.convention = recording.imu_convention};
  const ImuRange range = range_of(recording);
  options.accelerometer_range = std::min(options.accelerometer_range, range.accelerometer);
  options.gyroscope_range = std::min(options.gyroscope_range, range.gyroscope);
  return options;
}

InertialSlamSettings filter_settings(const Recording& recording,
                                     const InertialRunSettings& settings) {
  return recording.images ? for_images(settings.filter, recording.cameras.size()) : settings.filter;
}

InertialSession session_for(const Recording& recording, const InertialRunSettings& settings,
                            const InertialDrive& result, bool from_truth) {
  InertialSensors sensors{.cameras = recording.cameras,
                          .noise = result.imu_noise,
                          .imu = imu_options(recording),
                          .pixel_sigma = result.pixel_sigma};
  std::optional<InertialStart> start;
  if (from_truth) start = true_start(recording);
  return {filter_settings(recording, settings), settings.start, std::move(sensors),
          std::move(start)};
}

InertialDrive prepared(const Recording& recording, const InertialRunSettings& settings,
                       const InertialDriveOptions& options) {
  InertialDrive result;
  if (options.realtime) result.realtime = RealtimeFigures{.speed = *options.realtime};
  result.imu_noise = noise_of(recording);
  result.pixel_sigma = settings.filter.pixel_sigma.value_or(
      recording.single_pixel_sigma.value_or(recording.images ? kFrontendPixelSigma : 1));
  result.run.name = recording.name;
  result.run.extra_names = extra_names(settings.filter, recording.cameras.size());
  // A window's steps are not the filter's.
  if (options.estimator.window == 0) {
    result.run.stage_names = filter_stage_names();
    if (recording.images) {
      result.run.stage_names.insert(result.run.stage_names.begin(), "front_end");
    }
  }
  result.run.truth = recording.truth;
  result.run.plan = recording.plan;
  result.run.georeference = recording.georeference;
  return result;
}

}  // namespace chasles::app
