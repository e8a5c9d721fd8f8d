#include <cmath>

#include <chasles/robot/state_stream.hpp>

namespace chasles {

void StateStream::set_slam(const RobotSlam& slam) {
  slam_ = &slam;
  rate_density_ = slam.imu_noise().gyroscope_noise_density;
}

// At the time of an estimate the prediction is the estimate, with the angular rate of the sample.
void StateStream::take(std::span<const Estimate> estimates, VisualInertialSlam& slam) {
  if (estimates.empty()) return;
  const Estimate& e = estimates.back();
  any_ = true;
  if (e.health == Health::kLost) return;  // StatePredictor has none either
  if (options_.jumps) {
    const SlamReport report = slam.estimator().report();
    sink_.quality(e.health, static_cast<std::size_t>(report.resets) + report.closures.size());
  }
  if (options_.rate == Rate::kImages) send(slam.predicted(e.time));
  if (e.in_map) sink_.map_T_odom(e.in_map->world_T_map.inverse(), e.time);
  if (!points_are_due(e.time)) return;
  last_points_ = e.time;
  sink_.points(slam.estimator().map(), e.time);
}

// Stamps jump back where a recording is played again.
bool StateStream::points_are_due(Time time) const {
  if (options_.points_period <= 0) return false;
  return !last_points_ || time < *last_points_ ||
         to_seconds(time - *last_points_) >= options_.points_period;
}

void StateStream::take_sample(Time time, double period) {
  sample_period_ = period;
  if (options_.rate == Rate::kSamples) send(slam_->predicted(time));
}

void StateStream::send(const std::optional<PredictedState>& state) const {
  if (!state) return;
  const double sigma = rate_density_ / std::sqrt(sample_period_.load());
  sink_.odometry(body_state({.world_T_imu = state->state.world_T_imu,
                             .v_world = state->state.v_world,
                             .angular_rate_imu = state->angular_rate_imu,
                             .covariance = state->covariance,
                             .rate_variance = sigma * sigma},
                            options_.base_T_imu),
                 state->time);
}

}  // namespace chasles
