#include <chasles/error.hpp>
#include <chasles/pipeline/batch_input.hpp>

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
        "batch estimation takes the calibration as known: calibrate_extrinsics and "
        "calibrate_time_offset are for the filter; run the filter first, and use the calibration "
        "that it estimates");
  }
}

InertialBatchInput batch_input(const InertialSensors& sensors, const InertialSlamSettings& settings,
                               const InertialStart& start) {
  check_smoothing(settings);
  return {.cameras = sensors.cameras,
          .noise = scaled(sensors.noise, settings.imu_noise_scale),
          .imu = sensors.imu,
          .pixel_sigma = sensors.pixel_sigma,
          .time_offset = from_seconds(settings.time_offset),
          .samples = {},
          .frames = {},
          .start = start,
          .start_covariance = start_covariance(settings, start)};
}

InertialStart start_at(const Estimate& e) {
  return {.time = e.time,
          .nav_T_imu = e.world_T_imu,
          .v_nav = *e.v_world,
          .accelerometer_bias = e.additive.head<3>(),
          .gyroscope_bias = e.additive.tail<3>(),
          .covariance = e.covariance};
}

TimedMotion timed_motion(const Estimate& e) {
  return {.time = e.time,
          .state = {.world_T_imu = e.world_T_imu,
                    .v_world = *e.v_world,
                    .accelerometer_bias = e.additive.head<3>(),
                    .gyroscope_bias = e.additive.tail<3>()}};
}

}  // namespace chasles
