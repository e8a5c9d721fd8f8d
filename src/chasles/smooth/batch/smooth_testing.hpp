#pragma once

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/lie/testing.hpp>
#include <chasles/smooth/batch/batch.hpp>

// A small simulated flight past a few points, for tests.
namespace chasles::test {

/// A state plus errors in the reference chart, [rotation, position, velocity, biases].
inline InertialState moved(InertialState s, const Eigen::Matrix<double, 15, 1>& e) {
  s.world_T_imu.R = so3::exp(e.head<3>()) * s.world_T_imu.R;
  s.world_T_imu.p += e.segment<3>(3);
  s.v_world += e.segment<3>(6);
  s.accelerometer_bias += e.segment<3>(9);
  s.gyroscope_bias += e.tail<3>();
  return s;
}

/// (J^T J)^-1, of rows whose scales differ by many powers of ten.
inline Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& J) {
  const Eigen::MatrixXd H = J.transpose() * J;
  const Eigen::VectorXd s = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = s.asDiagonal() * H * s.asDiagonal();
  return s.asDiagonal() * unit.inverse() * s.asDiagonal();
}

inline InertialState integrated(InertialState s, const std::vector<ImuInterval>& intervals) {
  for (const ImuInterval& i : intervals) s = integrate(s, i, {0, 0, -kStandardGravity});
  return s;
}

struct SmallFlight {
  int frames = 8;
  double seconds_a_frame = 0.1;
  int cameras = 1;
  double noise = 1;    ///< factor on the drawn noise; the estimator assumes 1
  double speed = 1;    ///< factor on velocity and acceleration; 0: no motion
  double shaking = 1;  ///< factor on the acceleration alone
  double turning = 1;  ///< factor on the angular rate
  int landmarks = 25;
  std::uint64_t seed = 1;
  bool beside = false;  ///< fisheye cameras that look to the right of the way: most landmarks are
                        ///< 60 to 110 degrees off their axes
};

struct SmallScene {
  InertialBatchInput input;
  std::vector<TimedMotion> truth;  ///< of the start and of every frame
  std::map<LandmarkId, Eigen::Vector3d> landmarks;
};

inline Camera small_camera(double aside) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 400;
  camera.cx = 320;
  camera.cy = 240;
  // The camera points along the IMU's x axis.
  camera.cam_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  camera.cam_T_imu.p = Eigen::Vector3d(0.03 - aside, 0.02, -0.01);
  return camera;
}

inline Camera beside_camera(double aside) {
  Camera camera = small_camera(aside);
  camera.distortion = Distortion::kEquidistant;
  camera.coefficients = {0.01, -0.002, 0, 0};
  camera.fx = camera.fy = 110;
  const Eigen::Matrix3d turn = so3::exp({0, -1.5, 0});
  camera.cam_T_imu.R = turn * camera.cam_T_imu.R;
  camera.cam_T_imu.p = turn * camera.cam_T_imu.p;
  return camera;
}

inline Eigen::Vector3d small_rate(double t) {
  return 0.3 * Eigen::Vector3d(std::sin(1.3 * t), std::cos(2.9 * t), std::sin(1.7 * t + 1));
}

inline Eigen::Vector3d small_acceleration(double t) {
  return Eigen::Vector3d(-2 * std::sin(2 * t), 2 * std::cos(3.7 * t), 1.5 * std::sin(4.3 * t + 1));
}

/// Samples are means over intervals of 10 ms, so that the strapdown step is exact.
inline SmallScene small_scene(const SmallFlight& flight = {}) {
  Random random(flight.seed);
  const double tau = 0.01;
  const auto samples_a_frame = static_cast<int>(std::lround(flight.seconds_a_frame / tau));
  SmallScene scene;
  InertialBatchInput& in = scene.input;
  for (int i = 0; i < flight.cameras; ++i) {
    in.cameras.push_back(flight.beside ? beside_camera(0.2 * i) : small_camera(0.2 * i));
  }
  in.noise = {.accelerometer_noise_density = 0.004,
              .accelerometer_random_walk = 0.003,
              .gyroscope_noise_density = 0.0006,
              .gyroscope_random_walk = 0.0003};
  in.imu.convention = ImuConvention::kIntervalMean;
  in.pixel_sigma = 0.5;
  const auto normal3 = [&] { return Eigen::Vector3d(random.normal_vector(3)); };
  const Eigen::Vector3d gravity(0, 0, -kStandardGravity);
  const Time begin = std::chrono::seconds(100);

  InertialState state{.world_T_imu = {.R = so3::exp({0.05, -0.1, 0.4}), .p = {1, 2, 3}},
                      .v_world = flight.speed * Eigen::Vector3d(0.8, 0.6, 0.1)};
  Eigen::Matrix<double, 15, 1> sigma;
  sigma << 0.01, 0.01, 0, 0, 0, 0, 0.05, 0.05, 0.05, 0.02, 0.02, 0.02, 0.005, 0.005, 0.005;
  in.start_covariance = sigma.cwiseAbs2().asDiagonal();
  const Eigen::VectorXd e = flight.noise * sigma.cwiseProduct(random.normal_vector(15));
  in.start = {.time = begin, .nav_T_imu = state.world_T_imu, .v_nav = state.v_world};
  in.start.nav_T_imu.R = so3::exp(-e.head<3>()) * in.start.nav_T_imu.R;
  in.start.v_nav -= e.segment<3>(6);
  state.accelerometer_bias = e.segment<3>(9);
  state.gyroscope_bias = e.tail<3>();

  in.samples.push_back({.time = begin, .specific_force_imu = -gravity});
  scene.truth.push_back({.time = begin, .state = state});
  const double white = flight.noise / std::sqrt(tau), walk = flight.noise * std::sqrt(tau);
  for (int k = 1; k <= (flight.frames - 1) * samples_a_frame; ++k) {
    const double t = (k - 0.5) * tau;
    const Time time = begin + from_seconds(k * tau);
    const Eigen::Vector3d w = flight.turning * small_rate(t) + state.gyroscope_bias;
    const Eigen::Vector3d f =
        state.world_T_imu.R.transpose() *
            (flight.speed * flight.shaking * small_acceleration(t) - gravity) +
        state.accelerometer_bias;
    state = integrate(state, {.tau = tau, .specific_force_imu = f, .angular_rate_imu = w}, gravity);
    in.samples.push_back(
        {.time = time,
         .specific_force_imu = f + white * in.noise.accelerometer_noise_density * normal3(),
         .angular_rate_imu = w + white * in.noise.gyroscope_noise_density * normal3()});
    state.accelerometer_bias += walk * in.noise.accelerometer_random_walk * normal3();
    state.gyroscope_bias += walk * in.noise.gyroscope_random_walk * normal3();
    if (k % samples_a_frame == 0) scene.truth.push_back({.time = time, .state = state});
  }
  for (int i = 0; i < flight.landmarks; ++i) {
    const Eigen::Vector3d in_imu(random.uniform(2, 8), random.uniform(-2, 2),
                                 random.uniform(-1.5, 1.5));
    scene.landmarks[100 + i] = scene.truth.front().state.world_T_imu * in_imu;
  }
  for (const TimedMotion& m : scene.truth) {
    FeatureFrame frame{.time = m.time};
    for (const auto& [id, p] : scene.landmarks) {
      for (int c = 0; c < flight.cameras; ++c) {
        const Camera& camera = in.cameras[static_cast<std::size_t>(c)];
        const auto seen = project(camera, camera.cam_T_imu * (m.state.world_T_imu.inverse() * p));
        if (!seen || !in_image(camera, seen->pixel)) continue;
        frame.pixels.push_back(
            {.landmark = id,
             .camera = c,
             .pixel = seen->pixel +
                      flight.noise * in.pixel_sigma * Eigen::Vector2d(random.normal_vector(2))});
      }
    }
    in.frames.push_back(std::move(frame));
  }
  return scene;
}

/// The errors [rotation, position, velocity, biases] of a truth against an estimate, reference
/// chart.
inline Eigen::Matrix<double, 15, 1> motion_error(const InertialState& truth, const Estimate& m) {
  Eigen::Matrix<double, 15, 1> e;
  e << so3::log(truth.world_T_imu.R * m.world_T_imu.R.transpose()),
      truth.world_T_imu.p - m.world_T_imu.p, truth.v_world - *m.v_world,
      truth.accelerometer_bias - m.additive.head<3>(), truth.gyroscope_bias - m.additive.tail<3>();
  return e;
}

/// Adds a random walk to every track, of that many pixels per square root of a second.
inline void let_walk(SmallScene& scene, double walk) {
  Random random(11);
  std::map<std::pair<LandmarkId, int>, Eigen::Vector2d> errors;
  Time before = scene.input.frames.front().time;
  for (FeatureFrame& frame : scene.input.frames) {
    const double step = walk * std::sqrt(to_seconds(frame.time - before));
    before = frame.time;
    for (PixelObservation& o : frame.pixels) {
      Eigen::Vector2d& error =
          errors.try_emplace({o.landmark, o.camera}, Eigen::Vector2d::Zero()).first->second;
      error += step * Eigen::Vector2d(random.normal_vector(2));
      o.pixel += error;
    }
  }
}

}  // namespace chasles::test
