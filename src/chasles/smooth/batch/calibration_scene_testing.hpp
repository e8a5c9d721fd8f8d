#pragma once

#include <optional>
#include <stdexcept>

#include <chasles/imu/imu_correction_testing.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>

// The small flight with cameras whose calibration is wrong by as much as it says, for tests.
namespace chasles::test {

/// Plain least squares, with the covariance of the stated noise.
inline BatchSettings without_outliers() {
  BatchSettings settings;
  settings.loss = BatchLoss::kNone;
  settings.gate = 0;
  settings.covariance_factor = 1;
  return settings;
}

inline double squared_error(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
  return e.dot(P.ldlt().solve(e));
}

struct CalibrationScene : SmallScene {
  Calibration true_calibration = {};
  int empty_rows = 0;  ///< of the calibration's errors: those without a parameter

  InertialState motion_at(Time time) const {
    for (const TimedMotion& m : truth) {
      if (m.time == time) return m.state;
    }
    throw std::runtime_error("no frame has that time");
  }
  void consider_all() {
    for (int row = 0; row < input.calibration->covariance.rows(); ++row) {
      input.considered.push_back(row);
    }
  }
};

/// The true pose some seconds after, or before, the time of frame k > 0.
inline SE3 pose_after(const SmallScene& scene, const SmallFlight& flight, int k, double seconds) {
  constexpr double kTau = 0.01;  // of the samples of small_scene
  const auto samples_a_frame = static_cast<int>(std::lround(flight.seconds_a_frame / kTau));
  if (seconds < 0) {
    --k;
    seconds += flight.seconds_a_frame;
  }
  InertialState state = scene.truth[static_cast<std::size_t>(k)].state;
  state.accelerometer_bias.setZero();
  state.gyroscope_bias.setZero();
  const Eigen::Vector3d gravity(0, 0, -kStandardGravity);
  for (int i = k * samples_a_frame; seconds > 0; ++i, seconds -= kTau) {
    const double middle = (i + 0.5) * kTau;
    const Eigen::Vector3d a = flight.speed * flight.shaking * small_acceleration(middle);
    state = integrate(state,
                      {.tau = std::min(seconds, kTau),
                       .specific_force_imu = state.world_T_imu.R.transpose() * (a - gravity),
                       .angular_rate_imu = flight.turning * small_rate(middle)},
                      gravity);
  }
  return state.world_T_imu;
}

inline std::optional<Eigen::Vector2d> pixel_at(const CalibrationScene& scene,
                                               const SmallFlight& flight, const Camera& camera,
                                               int k, const Eigen::Vector3d& p) {
  Eigen::Vector2d pixel(camera.cx, camera.cy);
  for (int i = 0; i < 8; ++i) {  // the line that sees the point when it is read
    const double delay = *scene.true_calibration.time_offset + line_delay(camera, pixel);
    const SE3 world_T_imu = pose_after(scene, flight, k, delay);
    const auto seen = project(camera, camera.cam_T_imu * (world_T_imu.inverse() * p));
    if (!seen) return std::nullopt;
    pixel = seen->pixel;
  }
  return in_image(camera, pixel) ? std::optional(pixel) : std::nullopt;
}

/// Everything is estimated, with errors that have the covariance of the prior, times the factor
/// `errors`.
inline CalibrationScene calibration_scene(const SmallFlight& flight, double readout,
                                          double errors = 1) {
  CalibrationScene scene{small_scene(flight), {}, 0};
  InertialBatchInput& in = scene.input;
  for (Camera& camera : in.cameras) {
    camera.distortion = Distortion::kRadtan;
    camera.coefficients = {-0.2, 0.05, 1e-3, -1e-3};
    camera.shutter.readout = readout;
  }
  InertialSlamSettings settings;
  settings.calibrate_extrinsics = settings.calibrate_intrinsics = settings.calibrate_readout =
      Calibrate::kTrue;
  settings.calibrate_time_offset = Calibrate::kTrue;
  settings.initial_extrinsic_rotation_sigma = settings.initial_extrinsic_translation_sigma = 0.005;
  settings.initial_time_offset_sigma = 0.002;
  in.calibration = stated_calibration(settings, in.cameras);
  Random random(flight.seed + 1000);
  scene.true_calibration = *in.calibration;
  const Eigen::VectorXd sigma = in.calibration->covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd e = errors * sigma.cwiseProduct(random.normal_vector(sigma.size()));
  Eigen::Index row = 0;
  for (SE3& imu_T_camera : scene.true_calibration.imu_T_camera) {
    imu_T_camera.R = so3::exp(e.segment<3>(row)) * imu_T_camera.R;
    imu_T_camera.p += e.segment<3>(row + 3);
    row += 6;
  }
  *scene.true_calibration.time_offset += e[row++];
  for (Intrinsics& one : scene.true_calibration.intrinsics) {
    one.projection += e.segment<4>(row);
    if (one.has_readout) one.readout += e[row + Intrinsics::kReadoutRow];
    for (std::size_t i = 0; i < one.coefficients.size(); ++i) {
      one.coefficients[i] += e[row + 6 + static_cast<Eigen::Index>(i)];
    }
    scene.empty_rows += 6 * one.blocks() - 4 - (one.has_readout ? 1 : 0) -
                        static_cast<int>(one.coefficients.size());
    row += 6 * one.blocks();
  }
  const std::vector<Camera> cameras = calibrated(in.cameras, scene.true_calibration);
  in.frames.front().pixels.clear();  // which may be taken before the start
  for (int k = 1; k < flight.frames; ++k) {
    FeatureFrame& frame = in.frames[static_cast<std::size_t>(k)];
    frame.pixels.clear();
    for (const auto& [id, p] : scene.landmarks) {
      for (int c = 0; c < flight.cameras; ++c) {
        const auto pixel = pixel_at(scene, flight, cameras[static_cast<std::size_t>(c)], k, p);
        const Eigen::Vector2d noise = random.normal_vector(2);
        if (!pixel) continue;
        frame.pixels.push_back(
            {.landmark = id, .camera = c, .pixel = *pixel + flight.noise * in.pixel_sigma * noise});
      }
    }
  }
  return scene;
}

/// The settings that estimate the IMU's parameters, which are wrong by more than they usually are.
inline InertialSlamSettings imu_settings() {
  InertialSlamSettings settings;
  settings.calibrate_imu = Calibrate::kTrue;
  settings.initial_imu_scale_sigma = 0.02;
  settings.initial_imu_misalignment_sigma = 0.01;
  settings.initial_g_sensitivity_sigma = 0.002;
  return settings;
}

/// Lets the IMU of the scene have errors of its parameters, by these sigmas times the factor
/// `errors`, and its start depend on them, and estimates them besides what is estimated.
inline void measure_wrongly(CalibrationScene& scene, std::uint64_t seed, double errors = 1) {
  Random random(seed + 2000);
  InertialBatchInput& in = scene.input;
  const Calibration imu = *stated_calibration(imu_settings(), {});
  const Eigen::Index n = imu.covariance.rows();
  if (!in.calibration) in.calibration = scene.true_calibration = Calibration{};
  Calibration& calibration = *in.calibration;
  const Eigen::Index before = calibration.covariance.rows();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(before + n, before + n);
  P.topLeftCorner(before, before) = calibration.covariance;
  P.bottomRightCorner(n, n) = imu.covariance;
  calibration.covariance = P;
  calibration.imu = scene.true_calibration.imu = imu.imu;
  ImuCorrection& truth = *scene.true_calibration.imu;
  const Eigen::VectorXd sigma = imu.covariance.diagonal().cwiseSqrt();
  truth.set(errors * sigma.cwiseProduct(random.normal_vector(n)));
  for (ImuSample& sample : in.samples) sample = as_measured(truth, sample);
  in.start.by_imu = Eigen::MatrixXd::Zero(15, n);
  for (const int row : {0, 1, 6, 7, 8, 9, 10, 11, 12, 13, 14}) {
    in.start.by_imu.row(row) = random.normal_vector(n).transpose();
  }
  const Eigen::VectorXd e = in.start.by_imu * truth.parameters();
  in.start.nav_T_imu.R = so3::exp(-e.head<3>()) * in.start.nav_T_imu.R;
  in.start.v_nav -= e.segment<3>(6);
  in.start.accelerometer_bias -= e.segment<3>(9);
  in.start.gyroscope_bias -= e.tail<3>();
}

/// A scene with known cameras and such an IMU.
inline CalibrationScene imu_scene(const SmallFlight& flight, double errors = 1) {
  CalibrationScene scene{small_scene(flight), {}, 0};
  measure_wrongly(scene, flight.seed, errors);
  return scene;
}

}  // namespace chasles::test
