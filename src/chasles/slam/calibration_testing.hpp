#pragma once

#include <chasles/eval/nees.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Recordings whose calibration is wrong by a known amount, and the remaining error of the filter's
// estimate.
namespace chasles::test {

inline InertialSlamSettings calibrating() {
  InertialSlamSettings settings;
  settings.calibrate_extrinsics = Calibrate::kTrue;
  settings.calibrate_time_offset = Calibrate::kTrue;
  return settings;
}

/// Handheld motion with enough rotation and acceleration to make the whole calibration observable,
/// and an IMU rate that samples it well.
inline InertialScene shaken(int cameras) {
  InertialScene scene = short_hallway();
  auto& s = scene.settings;
  s.sections = 1;
  s.cameras = cameras;
  s.imu_rate = 400;
  s.roll_amplitude = s.pitch_amplitude = s.yaw_amplitude = 0.08;
  return scene;
}

/// The recording with its truth at every 2 ms, because frames with wrong stamps lie between poses.
inline Recording simulate_densely(const InertialScene& scene, std::uint64_t run) {
  Recording recording = simulate_inertial(scene, run);
  const Spline motion = inertial_motion(scene);
  const Time last = recording.truth.back().time;
  Trajectory truth;
  for (Time t = recording.truth.front().time; t <= last; t += std::chrono::milliseconds(2)) {
    truth.push_back({t, motion_at(motion, to_seconds(t - motion.start)).world_T_imu});
  }
  recording.truth = std::move(truth);
  return recording;
}

/// The true calibration, and the recording with its stated one.
struct Miscalibrated {
  Recording recording;
  Calibration truth;  ///< without a covariance
  InertialStart start;
};

/// The recording with cameras rotated by -errors (R = Exp(phi) R_stated) and shifted by them, 6 for
/// each camera, and with frames stamped early by the time offset, the last of `errors`.
inline Miscalibrated miscalibrated(Recording recording, const Eigen::VectorXd& errors,
                                   const InertialStart& start) {
  Miscalibrated result{.recording = std::move(recording), .truth = {}, .start = start};
  Eigen::Index row = 0;
  for (Camera& camera : result.recording.cameras) {
    const SE3 truth = camera.cam_T_imu.inverse();
    result.truth.imu_T_camera.push_back(truth);
    const SE3 stated{so3::exp(-errors.segment<3>(row)) * truth.R,
                     truth.p - errors.segment<3>(row + 3)};
    camera.cam_T_imu = stated.inverse();
    row += 6;
  }
  result.truth.time_offset = errors[row];
  for (FeatureFrame& frame : result.recording.frames) frame.time -= from_seconds(errors[row]);
  return result;
}

/// Errors drawn with the covariance that the settings state.
inline Miscalibrated drawn(const InertialScene& scene, const InertialSlamSettings& settings,
                           std::uint64_t run) {
  const Recording recording = simulate_densely(scene, run);
  const auto stated = *stated_calibration(settings, recording.cameras);
  Eigen::VectorXd errors = stated.covariance.diagonal().cwiseSqrt();
  const chasles::Random random = random_of_run(77, run);
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    errors[i] *= random.normal(Stream::kStart, 1, static_cast<std::uint32_t>(i));
  }
  return miscalibrated(recording, errors, draw_start(recording, settings, 1, run));
}

/// True minus estimated, in the coordinates of Calibration::covariance.
inline Eigen::VectorXd calibration_error(const Calibration& truth, const Calibration& estimate) {
  Eigen::VectorXd error(estimate.covariance.rows());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < estimate.imu_T_camera.size(); ++i, row += 6) {
    const SE3& known = truth.imu_T_camera[i];
    const SE3& found = estimate.imu_T_camera[i];
    error.segment<3>(row) = so3::log(known.R * found.R.transpose());
    error.segment<3>(row + 3) = known.p - found.p;
  }
  if (estimate.time_offset) error[row] = *truth.time_offset - *estimate.time_offset;
  return error;
}

}  // namespace chasles::test
