#include <utility>

#include <chasles/error.hpp>
#include <chasles/lab/batch_trial.hpp>

namespace chasles {
namespace {

ImuNoise scaled(ImuNoise noise, double factor) {
  noise.accelerometer_noise_density *= factor;
  noise.accelerometer_random_walk *= factor;
  noise.gyroscope_noise_density *= factor;
  noise.gyroscope_random_walk *= factor;
  return noise;
}

}  // namespace

void check_smoothing(const InertialSlamSettings& settings) {
  if (settings.calibrate_extrinsics || settings.calibrate_time_offset) {
    throw UsageError(
        "batch estimation takes the sensors' arrangement as known: calibrate_extrinsics and "
        "calibrate_time_offset are for the filter; run that first, and state what it found");
  }
}

InertialBatchInput batch_input(const Recording& recording, const InertialSlamSettings& settings,
                               const InertialStart& start) {
  check_smoothing(settings);
  return {.cameras = recording.cameras,
          .noise = scaled(recording.imu_noise.value_or(ImuNoise{}), settings.imu_noise_scale),
          .imu = {.convention = recording.imu_convention},
          .pixel_sigma = settings.pixel_sigma.value_or(recording.single_pixel_sigma.value_or(1)),
          .time_offset = from_seconds(settings.time_offset),
          .samples = recording.imu,
          .frames = recording.frames,
          .start = start,
          .start_covariance = start_covariance(settings, start)};
}

InertialEstimate estimate_of(const BatchMotion& motion) {
  InertialEstimate e;
  e.time = motion.time;
  e.motion = motion.motion;
  e.observations = e.used = motion.observations;
  return e;
}

InertialEstimate estimate_of(const WindowMotion& motion) {
  InertialEstimate e = estimate_of(static_cast<const BatchMotion&>(motion));
  e.rejected = motion.rejected;
  e.in_state = motion.in_window;
  e.landmarks = motion.landmarks;
  e.health = motion.health;
  return e;
}

BatchTrial run_batch_trial(const FilterVariant& filter, const BatchSettings& settings,
                           const Recording& recording, const InertialStart& start,
                           std::vector<TimedMotion> initial) {
  InertialBatchInput input = batch_input(recording, filter.settings, start);
  input.initial = std::move(initial);
  const InertialBatchResult result = smooth(input, filter.settings.chart, settings);
  BatchTrial batch{.trial = {.filter = filter.name}, .report = result.report};
  for (const BatchMotion& motion : result.motions) {
    InertialEstimate e = estimate_of(motion);
    e.landmarks = result.report.landmarks;
    if (!add_to_trial(filter.settings.chart, recording, start.time, e, batch.trial)) break;
  }
  batch.trial.seconds_cpu = result.report.seconds_solve + result.report.seconds_covariance;
  end_trial(recording, batch.trial);
  return batch;
}

Trial run_window_trial(const FilterVariant& filter, const BatchSettings& settings,
                       const Recording& recording, const InertialStart& start) {
  const InertialWindowResult result = slide(batch_input(recording, filter.settings, start),
                                            filter.settings.chart, settings, filter.window);
  Trial trial{.filter = filter.name};
  for (const WindowMotion& motion : result.motions) {
    const InertialEstimate e = estimate_of(motion);
    if (!add_to_trial(filter.settings.chart, recording, start.time, e, trial)) break;
  }
  end_trial(recording, trial);
  return trial;
}

TimedMotion timed_motion(const InertialEstimate& e) {
  return {.time = e.time,
          .state = {.world_T_imu = e.motion.nav_T_imu,
                    .v_world = e.motion.v_nav,
                    .accelerometer_bias = e.motion.biases.head<3>(),
                    .gyroscope_bias = e.motion.biases.tail<3>()}};
}

std::vector<TimedMotion> filter_motions(const FilterVariant& filter, const Recording& recording,
                                        const InertialStart& start) {
  std::vector<TimedMotion> motions;
  run_filter(filter, recording, start, [&](const InertialEstimate& e) {
    motions.push_back(timed_motion(e));
    return e.health != Health::kLost;
  });
  return motions;
}

}  // namespace chasles
