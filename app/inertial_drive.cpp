#include "inertial_drive.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/lab/trial.hpp>

#include "filter_options.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "stopwatch.hpp"
#include "summary.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

// The truth as it is: nothing is drawn.
InertialStart true_start(const Recording& recording) {
  if (recording.truth.empty()) {
    throw Error(ExitCode::kNotInitialised,
                fmt::format("{}: has no truth to start from (--truth FILE gives one); an inertial "
                            "run does not yet find its start by itself",
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

RunState run_state(const InertialEstimate& e, double milliseconds) {
  RunState state{.time = e.time,
                 .world_T_imu = e.motion.nav_T_imu,
                 .pose_covariance = e.motion.covariance.topLeftCorner<6, 6>(),
                 .extra = {e.motion.v_nav.begin(), e.motion.v_nav.end()},
                 .extra_sigma = {},
                 .nis = e.nis,
                 .nis_dof = e.nis_dof,
                 .observations = e.observations,
                 .used = e.used,
                 .rejected = e.rejected,
                 .added = e.added,
                 .in_state = e.in_state,
                 .landmarks = e.landmarks,
                 .health = name(e.health),
                 .milliseconds = milliseconds};
  state.extra.insert(state.extra.end(), e.motion.biases.begin(), e.motion.biases.end());
  for (int row = 6; row < 15; ++row) {
    state.extra_sigma.push_back(std::sqrt(e.motion.covariance(row, row)));
  }
  return state;
}

std::vector<std::string> extra_names() {
  std::vector<std::string> names;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(of) + axis);
  }
  return names;
}

}  // namespace

InertialDrive drive(const Recording& recording, const InertialSlamSettings& settings,
                    const Interrupt& interrupt, bool quiet) {
  if (recording.cameras.empty()) throw InputError(recording.name + ": has no camera");
  const InertialStart start = true_start(recording);
  InertialDrive result;
  result.imu_noise = noise_of(recording);
  result.pixel_sigma = settings.pixel_sigma.value_or(recording.single_pixel_sigma.value_or(1));
  result.run.name = recording.name;
  result.run.extra_names = extra_names();
  result.run.truth = recording.truth;
  InertialSlam slam(settings, recording.cameras, result.imu_noise,
                    {.convention = recording.imu_convention}, result.pixel_sigma, start);
  Progress progress(recording.frames.size(), quiet);
  EventStream events(recording);
  Stopwatch frame_time;
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame || frame->time < start.time) continue;
    const InertialEstimate e = slam.process(*frame);
    result.run.states.push_back(run_state(e, 1e3 * frame_time.seconds()));
    progress.show(result.run.states.size(), to_seconds(e.time - start.time));
    result.interrupted = interrupt.requested();
    if (result.interrupted || e.health == Health::kLost) break;
    frame_time = {};
  }
  for (const MapLandmark& l : slam.map_nav()) {
    result.run.landmarks.push_back({.id = l.id,
                                    .p_world = l.p_world,
                                    .covariance = l.covariance,
                                    .observations = l.observations});
  }
  result.imu = slam.imu_counts();
  return result;
}

Json summary_json(const InertialDrive& drive, const InertialSlamSettings& settings,
                  const Recording& recording) {
  std::vector<std::string> remarks = recording.remarks;
  remarks.push_back(
      "started from the truth of the first frame, with the uncertainty of the settings");
  Json summary = run_json(drive.run, "slam", settings.chart, recording.true_landmarks, remarks);
  summary["settings"] = settings_json(settings);
  const ImuNoise& noise = drive.imu_noise;
  summary["noise"] = {{"pixel_sigma", drive.pixel_sigma},
                      {"accelerometer_noise_density", noise.accelerometer_noise_density},
                      {"accelerometer_random_walk", noise.accelerometer_random_walk},
                      {"gyroscope_noise_density", noise.gyroscope_noise_density},
                      {"gyroscope_random_walk", noise.gyroscope_random_walk}};
  const ImuBuffer::Counts& imu = drive.imu;
  summary["imu"] = {{"used", imu.used},           {"not_finite", imu.not_finite},
                    {"not_later", imu.not_later}, {"gaps", imu.gaps},
                    {"saturated", imu.saturated}, {"extrapolated", imu.extrapolated}};
  summary["remarks"] = remarks;
  return summary;
}

}  // namespace chasles::app
