#pragma once

#include <string>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <chasles/filter/simulated_drive_testing.hpp>
#include <chasles/velocity/body_velocity_model.hpp>

/// The motion models of the filter's tests: initialisation, propagation and measurement of the
/// core. Included by tests only.
namespace chasles::test {

enum class Motion { kVelocityState, kVelocityInput, kInertial };

inline std::string motion_test_name(Motion motion) {
  if (motion == Motion::kVelocityState) return "velocity_state";
  return motion == Motion::kVelocityInput ? "velocity_input" : "inertial";
}

inline BodyVelocityModel velocity_model(Motion motion) {
  return {.velocity_state = motion == Motion::kVelocityState, .gyro_bias = true, .scale = true};
}

inline BodyVelocityNoise velocity_noise() {
  BodyVelocityNoise noise{
      .sample_sigma = {}, .walk = {}, .gyro_bias_walk = 1e-3, .scale_walk = 1e-3};
  noise.sample_sigma << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  noise.walk << 0.3, 0.3, 0.3, 2, 1, 1;
  return noise;
}

inline Inertial inertial_model() {
  Inertial model;
  model.f_sigma = 0.3;
  model.w_sigma = 0.02;
  model.f_bias_walk = 1e-2;
  model.w_bias_walk = 1e-3;
  return model;
}

inline State initial_state(Motion motion, const DriveFrame& first) {
  State x;
  x.world_T_imu = first.world_T_imu;
  x.additive.setZero(motion == Motion::kInertial ? 6 : velocity_model(motion).size());
  if (motion == Motion::kInertial) x.v_world = first.world_T_imu.R * first.velocity.linear_imu;
  return x;
}

/// Diagonal; `pose_sigma`: standard deviation of the pose.
inline Eigen::MatrixXd initial_covariance(Motion motion, double pose_sigma) {
  Eigen::VectorXd sigma(motion == Motion::kInertial ? 15 : 6 + velocity_model(motion).size());
  sigma.head<6>().setConstant(pose_sigma);
  if (motion == Motion::kInertial) {
    sigma.segment<3>(6).setConstant(0.3);
    sigma.segment<3>(9).setConstant(0.1);
    sigma.tail<3>().setConstant(0.02);
  } else {
    if (motion == Motion::kVelocityState) sigma.segment<6>(6).setConstant(10);
    sigma.segment<3>(sigma.size() - 4).setConstant(0.02);
    sigma[sigma.size() - 1] = 0.05;
  }
  return sigma.cwiseAbs2().asDiagonal();
}

inline Prediction predict_drive(Motion motion, const State& x, const DriveFrame& frame) {
  if (motion == Motion::kInertial) return inertial_model().predict(x, frame.inertial, kDriveStep);
  return predict(velocity_model(motion), x, frame.velocity, kDriveStep, velocity_noise());
}

}  // namespace chasles::test
