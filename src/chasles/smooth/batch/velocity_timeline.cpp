#include <algorithm>
#include <string>

#include <chasles/base/error.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/floors_detail.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>
#include <chasles/velocity/velocity_model.hpp>

namespace chasles {

void check_smoothing(const VelocitySlamSettings& s) {
  if (s.mode != SlamMode::kSlam) {
    throw UsageError("batch estimation is for --mode slam, the mode is " +
                     std::string(name_of(s.mode)));
  }
  if (s.update_with_first_observation || s.initial_landmark_sigma) {
    throw UsageError(
        "batch estimation uses each observation once, with its own noise: expected "
        "update_with_first_observation=false and initial_landmark_sigma=auto");
  }
}

namespace smooth_detail {
namespace {

VelocityStart start_of(const VelocitySlamSettings& settings, const VelocitySlamNoise& noise,
                       const BodyVelocityModel& model) {
  VelocityStart start;
  start.mean.additive = Eigen::VectorXd::Zero(model.size());
  Eigen::MatrixXd P = initial_covariance(settings, noise);
  Eigen::VectorXd floor = Eigen::VectorXd::Constant(P.rows(), kFloor * kFloor);
  if (model.gyro_bias)
    floor.segment<3>(6 + model.bias_index()).setConstant(kRateFloor * kRateFloor);
  P.diagonal() += floor;
  auto whitening = whitening_of(P);
  if (!whitening) throw InputError("the start's covariance is not positive and finite");
  start.whitening = std::move(*whitening);
  return start;
}

}  // namespace

VelocityTimeline::VelocityTimeline(const VelocitySlamSettings& settings,
                                   const VelocitySlamNoise& noise)
    : model(model_of(settings, noise)), settings_(settings), noise_(noise.motion) {
  check_smoothing(settings);
  start = start_of(settings, noise, model);
}

// Predicts the state there from the previous one and the velocity.
int VelocityTimeline::advance_to(Time time, const BodyVelocity& held) {
  if (keyframes.empty()) {
    keyframes.push_back({.time = time, .state = start.mean});
    return 0;
  }
  const VelocityKeyframe& last = keyframes.back();
  if (time < last.time) {
    throw InputError("time runs backwards: " + std::to_string(time.count()) + " ns after " +
                     std::to_string(last.time.count()) + " ns");
  }
  if (time > last.time) {
    links.push_back(twist_link(model, to_seconds(time - last.time), held, noise_));
    State x;
    x.world_T_imu = last.state.world_T_imu;
    x.additive = last.state.additive;
    const Vector6d xi = links.back().tau * corrected_velocity(model, x, held);
    keyframes.push_back(
        {.time = time,
         .state = {.world_T_imu = x.world_T_imu * se3::exp(xi), .additive = x.additive}});
  }
  return keyframes.last();
}

int VelocityTimeline::add(const BodyVelocity& u) {
  if (!u.linear_imu.allFinite() || !u.angular_imu.allFinite()) {
    throw InputError("the velocity at " + std::to_string(u.time.count()) + " ns is not finite");
  }
  const int k = advance_to(u.time, held_velocity(settings_, velocity_.value_or(u), u));
  velocity_ = u;
  if (!model.velocity_state) return k;
  samples.push_back({.keyframe = k, .velocity = u, .noise = sample_noise(settings_, noise_, u)});
  State x;
  x.additive = keyframes.back().state.additive;
  const BodyVelocityModel as_input{.velocity_state = false, .gyro_bias = false, .scale = false};
  keyframes.back().state.additive.head<6>() = corrected_velocity(as_input, x, u);
  return k;
}

int VelocityTimeline::add(const FeatureFrame& frame) {
  const int k = advance_to(frame.time, velocity_.value_or(BodyVelocity{}));
  keyframes.back().framed = true;
  keyframes.back().offered += static_cast<int>(frame.observations.size());
  return k;
}

void VelocityTimeline::drop_before(int keyframe) {
  keyframes.drop_before(keyframe);
  links.drop_before(keyframe);
  while (!samples.empty() && samples.front().keyframe < keyframe) samples.pop_front();
}

}  // namespace smooth_detail
}  // namespace chasles
