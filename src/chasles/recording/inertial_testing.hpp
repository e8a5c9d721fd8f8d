#pragma once

#include <cmath>

#include <chasles/lie/so3.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/recording/testing.hpp>

// An IMU in rotation and translation, in closed form.
namespace chasles::test {

inline const Eigen::Vector3d kBias(0.1, -0.2, 0.15);  ///< of the accelerometer [m/s^2]

/// R = Exp(a sin) Exp(b sin): every axis rotates by about a radian.
inline Eigen::Matrix3d swung_rotation(double t) {
  return so3::exp({0.9 * std::sin(1.1 * t), 0, 0.4}) *
         so3::exp({0, 0.8 * std::sin(0.7 * t + 1), 0.5 * std::sin(1.7 * t)});
}

/// The pose at time t [s]; the acceleration is -1.3^2 (p - p_middle) by axis.
inline StampedPose swung_pose(double t) {
  return {.time = from_seconds(t),
          .pose = {swung_rotation(t), Eigen::Vector3d(0.5, 0.3, -0.2) * std::sin(1.3 * t)}};
}

/// Truth every 50 ms and IMU samples every 5 ms, from before the truth to after it. The only error
/// is the bias.
inline Recording swung(const Eigen::Vector3d& gravity_world, double seconds) {
  Recording r;
  r.name = "swung";
  const int steps = static_cast<int>(std::lround(seconds / 0.005));
  for (int k = 0; k <= steps; ++k) {
    const double t = 0.005 * k;
    const StampedPose pose = swung_pose(t);
    const Eigen::Vector3d a = -1.3 * 1.3 * pose.pose.p;
    const Eigen::Matrix3d before = swung_rotation(t - 1e-4), after = swung_rotation(t + 1e-4);
    r.imu.push_back({.time = pose.time,
                     .specific_force_imu = pose.pose.R.transpose() * (a - gravity_world) + kBias,
                     .angular_rate_imu = so3::log(before.transpose() * after) / 2e-4});
    if (k % 10 == 5) r.truth.push_back(pose);
  }
  return r;
}

/// The camera of a phone: fisheye lens, 5 cm from the IMU.
inline Camera fisheye() {
  return {.width = 640,
          .height = 480,
          .fx = 300.1,
          .fy = 301.7,
          .cx = 321.3,
          .cy = 239.9,
          .distortion = Distortion::kEquidistant,
          .coefficients = {0.01, -0.003, 1e-3 / 3, -1e-5},
          .cam_T_imu = {so3::exp({0.1, -2, 0.3}), {0.05, 0.01, -0.02}}};
}

/// `swung` as a whole recording: two cameras, frames, truth of every kind.
inline Recording inertial() {
  Random random(3);
  Recording r = swung({0, 0, -kStandardGravity}, 2);
  r.imu_convention = ImuConvention::kIntervalMean;
  r.imu_noise = ImuNoise{2e-3, 3e-3, 1.0 / 3 * 1e-4, 0};
  r.cameras = {fisheye(), fisheye()};
  r.cameras[1].distortion = Distortion::kNone;
  r.cameras[1].coefficients = {};
  r.single_pixel_sigma = 1.0 / 3;
  for (const StampedPose& row : r.truth) {
    FeatureFrame& frame = r.frames.emplace_back();
    frame.time = row.time;
    for (int j = 0; j < 6; ++j) {
      frame.pixels.push_back({.landmark = j / 2,
                              .camera = j % 2,
                              .pixel = {random.uniform(0, 640), random.uniform(0, 480)}});
    }
    r.true_motion.push_back({.time = row.time,
                             .v_world = {random.normal(), random.normal(), random.normal()},
                             .accelerometer_bias = kBias / 3,
                             .gyroscope_bias = {random.normal(), 1e-17, -0.0}});
  }
  r.frames[3].pixels.clear();
  for (int j = 0; j < 3; ++j) {
    r.true_landmarks.push_back({.id = j, .p_world = {random.normal(), 2, 3}});
  }
  return r;
}

}  // namespace chasles::test
