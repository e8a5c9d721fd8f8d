#include <algorithm>
#include <cmath>

#include <chasles/constants.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/filter/error_chart.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/pipeline/truth.hpp>

namespace chasles {
namespace {

constexpr Time kLongestTruthGap =
    std::chrono::milliseconds(100);  // longer gaps are not interpolated
constexpr double kSlopeReach = 0.5;  // [s] to both sides
constexpr double kSlopeKnots = 0.1;  // [s]

// The velocity at that time from a spline through the true positions around it.
Eigen::Vector3d slope(const Trajectory& truth, Time time) {
  Trajectory near;
  for (const StampedPose& pose : truth) {
    if (std::abs(to_seconds(pose.time - time)) <= kSlopeReach) near.push_back(pose);
  }
  const Spline spline = fit_spline(near, kSlopeKnots);
  return motion_at(spline, to_seconds(time - spline.start)).v_world;
}

Eigen::Vector3d true_velocity(const Recording& recording, Time time) {
  const auto known = std::ranges::find(recording.true_motion, time, &TrueMotion::time);
  return known != recording.true_motion.end() ? known->v_world : slope(recording.truth, time);
}

}  // namespace

std::optional<SE3> truth_at(const Trajectory& truth, Time time) {
  const auto next = std::ranges::lower_bound(truth, time, {}, &StampedPose::time);
  if (next == truth.end()) return std::nullopt;
  if (next->time == time) return next->pose;
  if (next == truth.begin()) return std::nullopt;
  const StampedPose& before = *std::prev(next);
  if (next->time - before.time > kLongestTruthGap) return std::nullopt;
  const double part = to_seconds(time - before.time) / to_seconds(next->time - before.time);
  SE3 pose;
  pose.p = before.pose.p + part * (next->pose.p - before.pose.p);
  pose.R = before.pose.R * so3::exp(part * so3::log(before.pose.R.transpose() * next->pose.R));
  return pose;
}

InertialStart true_start(const Recording& recording) {
  if (recording.truth.empty()) {
    throw InputError("recording '" + recording.name + "' has no truth");
  }
  for (std::size_t i = 0; i < frame_count(recording); ++i) {
    const Time time = frame_time(recording, i);
    const auto pose = truth_at(recording.truth, time);
    if (pose) return {.time = time, .nav_T_imu = *pose, .v_nav = true_velocity(recording, time)};
  }
  throw InputError("recording '" + recording.name +
                   "' has no frame at whose time its truth is known");
}

double state_nees(const std::string& chart, const Recording& recording, const Estimate& e) {
  const auto known = std::ranges::lower_bound(recording.true_motion, e.time, {}, &TrueMotion::time);
  const auto pose = truth_at(recording.truth, e.time);
  if (known == recording.true_motion.end() || known->time != e.time || !pose) return kNaN;
  State truth{.world_T_imu = *pose, .v_world = known->v_world, .additive = Eigen::VectorXd(6)};
  truth.additive << known->accelerometer_bias, known->gyroscope_bias;
  const State estimate{.world_T_imu = e.world_T_imu, .v_world = *e.v_world, .additive = e.additive};
  const ErrorChart& coordinates = error_chart(chart);
  Eigen::MatrixXd P = e.covariance;
  for (int side = 0; side < 2; ++side) {
    push(coordinates, estimate, P);
    P.transposeInPlace();
  }
  return normalised_square(local(coordinates, estimate, truth), P);
}

}  // namespace chasles
