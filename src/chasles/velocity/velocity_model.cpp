#include <cmath>

#include <chasles/velocity/velocity_model.hpp>

namespace chasles {
namespace {

constexpr double kUnknownVelocity = 100;  // [m/s, rad/s]

}  // namespace

BodyVelocityModel model_of(const VelocitySlamSettings& s, const VelocitySlamNoise& noise) {
  const bool slam = s.mode == SlamMode::kSlam;
  const bool state = slam && s.velocity == VelocityRole::kMeasured;
  return {.velocity_state = state,
          .gyro_bias = slam && s.gyro_bias,
          .scale = slam && s.velocity_scale,
          .level = state && noise.level_velocities};
}

std::vector<std::string> additive_names(const BodyVelocityModel& model) {
  std::vector<std::string> names;
  const auto axes = [&](const std::string& of) {
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(of + axis);
  };
  if (model.velocity_state) axes("angular_velocity");
  if (model.velocity_state) axes("linear_velocity");
  if (model.gyro_bias) axes("gyro_bias");
  if (model.scale) names.push_back("log_velocity_scale");
  if (model.level) names.insert(names.end(), {"tilt_x", "tilt_y", "velocity_heading"});
  return names;
}

Eigen::MatrixXd initial_covariance(const VelocitySlamSettings& s, const VelocitySlamNoise& noise) {
  const BodyVelocityModel model = model_of(s, noise);
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(6 + model.size());
  if (s.mode != SlamMode::kMap) sigma.head<6>().setConstant(s.initial_pose_sigma);
  if (model.velocity_state) sigma.segment<6>(6).setConstant(kUnknownVelocity);
  if (model.gyro_bias) sigma.segment<3>(6 + model.bias_index()).setConstant(noise.gyro_bias_sigma);
  if (model.scale) sigma[6 + model.scale_index()] = s.velocity_scale_sigma;
  if (model.level) {
    sigma.segment<2>(6 + model.tilt_index()).setConstant(s.tilt_sigma);
    sigma[6 + model.heading_index()] = s.velocity_heading_sigma;
  }
  return sigma.cwiseAbs2().asDiagonal();
}

BodyVelocityNoise sample_noise(const VelocitySlamSettings& s, const BodyVelocityNoise& noise,
                               const BodyVelocity& u) {
  BodyVelocityNoise result = noise;
  const double relative = s.velocity_relative_sigma * u.linear_imu.norm();
  for (double& sigma : result.sample_sigma.tail<3>()) sigma = std::hypot(sigma, relative);
  return result;
}

BodyVelocity held_velocity(const VelocitySlamSettings& s, const BodyVelocity& before,
                           const BodyVelocity& u) {
  if (s.hold != VelocityHold::kMidpoint) return before;
  return {.time = before.time,
          .linear_imu = (before.linear_imu + u.linear_imu) / 2,
          .angular_imu = (before.angular_imu + u.angular_imu) / 2};
}

}  // namespace chasles
