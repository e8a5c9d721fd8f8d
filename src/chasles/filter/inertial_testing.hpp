#pragma once

#include <vector>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/filter/testing.hpp>

/// Shared by the tests of the inertial filter: cameras with a lever arm, samples, and a filter with
/// all optional states. Included by tests only.
namespace chasles::test {

/// A camera of each lens model, displaced from the IMU and rotated against it.
inline std::vector<Camera> inertial_cameras() {
  Eigen::Matrix3d axes;  // z forward, x right, y down, of an IMU with x forward
  axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  std::vector<Camera> result{pinhole_camera(), euroc_camera(), fisheye_camera()};
  result[0].cam_T_imu = {axes * so3::exp({0.02, -0.03, 0.04}), {0.05, -0.02, 0.1}};
  result[1].cam_T_imu = {axes * so3::exp({-0.05, 0.02, 0.03}), {-0.11, 0.03, 0.02}};
  result[2].cam_T_imu = {axes * so3::exp({0.01, 0.04, -0.02}), {0.2, 0.1, -0.05}};
  return result;
}

/// A point in front of all of them, `depth` metres ahead, in the IMU's axes.
inline Eigen::Vector3d point_ahead(Random& random, double depth) {
  return {depth, 0.15 * depth * random.normal(), 0.1 * depth * random.normal()};
}

inline ImuNoise imu_noise() {
  return {.accelerometer_noise_density = 2e-2,
          .accelerometer_random_walk = 3e-3,
          .gyroscope_noise_density = 2e-3,
          .gyroscope_random_walk = 2e-4};
}

/// Gravity with three components, for a nav frame that is not level.
inline InertialModel inertial_model_askew() {
  return {.gravity_nav = {1, -2, -9.5}, .noise = imu_noise()};
}

/// Samples of a hand-held device while walking, intervals of different lengths.
inline std::vector<ImuInterval> imu_intervals(Random& random, int count) {
  std::vector<ImuInterval> result;
  for (int i = 0; i < count; ++i) {
    result.push_back({.tau = random.uniform(0.02, 0.1),
                      .specific_force_imu = Eigen::Vector3d(0, 0, 9.8) + random.normal_vector(3),
                      .angular_rate_imu = random.normal_vector(3),
                      .noise_scale = random.uniform(1, 3)});
  }
  return result;
}

/// The state after a prediction: landmarks and clones are unchanged.
inline State predicted(State x, const Prediction& prediction) {
  x.world_T_imu = prediction.world_T_imu;
  x.v_world = prediction.v_world;
  x.additive = prediction.additive;
  return x;
}

/// Extends a matrix of the core to all errors of the state, by the identity.
inline Eigen::MatrixXd with_the_others(const Eigen::MatrixXd& core, const State& x) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Identity(x.size(), x.size());
  result.topLeftCorner(core.rows(), core.cols()) = core;
  return result;
}

/// T(x) of the chart.
inline Eigen::MatrixXd change_of_chart(const ErrorChart& chart, const State& x) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(x.size(), x.size());
  push(chart, x, T);
  return T;
}

/// Measurements in textbook form: one H for all errors of the state.
struct DenseMeasurement {
  Eigen::MatrixXd H, R;
  Eigen::VectorXd r;
};

inline DenseMeasurement dense_measurement(const State& x, const std::vector<Measurement>& all) {
  Eigen::Index m = 0;
  for (const Measurement& z : all) m += z.residual.size();
  DenseMeasurement result{Eigen::MatrixXd::Zero(m, x.size()), Eigen::MatrixXd::Zero(m, m),
                          Eigen::VectorXd(m)};
  Eigen::Index at = 0;
  for (const Measurement& z : all) {
    const Eigen::Index k = z.residual.size();
    result.H.block(at, z.core_column, k, z.d_core.cols()) += z.d_core;
    if (z.landmark >= 0) {
      const int row = x.landmarks[static_cast<std::size_t>(z.landmark)].row;
      result.H.block(at, row, k, 3) += z.d_landmark;
    }
    for (const Measurement::OfClone& clone : z.clones) {
      result.H.block(at, clone.row, k, 6) += clone.d;
    }
    result.R.block(at, at, k, k) = z.noise;
    result.r.segment(at, k) = z.residual;
    at += k;
  }
  return result;
}

/// Propagates a filter by a small motion, with noise on every error of its core.
inline void walk_on(Ekf& filter, Random& random) {
  const State& x = filter.state();
  const int n = x.core_size();
  Prediction step{.world_T_imu = x.world_T_imu,
                  .v_world = x.v_world,
                  .additive = x.additive,
                  .F = Eigen::MatrixXd::Identity(n, n),
                  .Q = random_covariance(random, n, 0.02)};
  for (int j = 0; j < n; ++j) step.F.col(j) += 0.05 * random.normal_vector(n);
  step.world_T_imu.R = step.world_T_imu.R * so3::exp(0.05 * random.normal_vector(3));
  step.world_T_imu.p += 0.5 * random.normal_vector(3);
  filter.propagate(step);
}

inline void add_cartesian(Ekf& filter, Random& random, LandmarkId id) {
  NewLandmark fresh;
  fresh.id = id;
  fresh.p_world = filter.state().world_T_imu * point_ahead(random, random.uniform(6, 12));
  for (int j = 0; j < 6; ++j) fresh.d_pose.col(j) = random.normal_vector(3);
  fresh.noise = random_covariance(random, 3, 0.1);
  filter.add({&fresh, 1});
}

/// Anchored on the latest clone.
inline void add_anchored(Ekf& filter, Random& random, LandmarkId id, const Camera& known,
                         int index = 0) {
  const Camera camera = as_estimated(known, filter.state(), index);
  NewLandmark fresh;
  fresh.camera = index;
  fresh.id = id;
  fresh.anchor = filter.state().clones.back().id;
  fresh.cam_T_imu = camera.cam_T_imu;
  const Eigen::Vector3d p_cam = camera.cam_T_imu * point_ahead(random, random.uniform(6, 12));
  fresh.inverse_depth << p_cam.head<2>() / p_cam.z(), 1 / p_cam.z();
  fresh.noise = random_covariance(random, 3, 0.01);
  filter.add({&fresh, 1});
}

/// A filter with a core of pose, velocity, biases and, if so, nav_T_world; clones 0, 1, 2 and
/// landmarks of both forms alternate, and all errors are correlated. The landmarks are 100
/// (Cartesian), 101 (anchored on 0), 102, 103 (1), 104 and 105 (2). `calibrating`: the extrinsics
/// of the three cameras, with errors against inertial_cameras(), and a time offset are estimated.
inline Ekf inertial_filter(const ErrorChart& chart, Random& random, bool nav = true,
                           bool calibrating = false,
                           const Ekf::Options& options = {.map = Ekf::Map::kFrozen}) {
  State x = random_state(random, {.velocity = true, .additive = 6, .nav = nav});
  const std::vector<Camera> cameras = inertial_cameras();
  if (calibrating) {
    for (const Camera& camera : cameras) {
      const SE3 off{so3::exp(0.02 * random.normal_vector(3)), 0.02 * random.normal_vector(3)};
      x.imu_T_camera.push_back(off * camera.cam_T_imu.inverse());
    }
    x.time_offset = 0.01;
  }
  Ekf filter(chart, x, random_covariance(random, x.core_size(), 0.05), options);
  for (int i = 0; i < 3; ++i) {
    walk_on(filter, random);
    add_cartesian(filter, random, 100 + 2 * i);
    filter.clone_pose(i, from_seconds(0.3 * i));
    walk_on(filter, random);
    add_anchored(filter, random, 101 + 2 * i, cameras[static_cast<std::size_t>(i)], i);
  }
  walk_on(filter, random);
  return filter;
}

/// Every landmark of the state observed by every camera, some pixels from its prediction.
inline std::vector<Measurement> pixel_measurements(const State& x, Random& random) {
  std::vector<Measurement> result;
  int index = -1;
  for (const Camera& camera : inertial_cameras()) {
    ++index;
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      auto z = measure_pixel(camera, 1, x, static_cast<int>(i), Eigen::Vector2d::Zero(),
                             Linearisation::kCurrent, index);
      if (!z) continue;
      z->residual = random.normal_vector(2);
      result.push_back(*z);
    }
  }
  return result;
}

}  // namespace chasles::test
