#include <algorithm>
#include <cmath>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/spline.hpp>
#include <chasles/pipeline/truth.hpp>

namespace chasles {
namespace {

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

}  // namespace

std::optional<SE3> true_pose_at(const Recording& recording, Time time) {
  return pose_at(recording.truth, time, recording.pairing.longest_gap);
}

std::optional<TrueMotion> true_motion_at(const Recording& recording, Time time) {
  const std::vector<TrueMotion>& motion = recording.true_motion;
  const auto next = std::ranges::lower_bound(motion, time, {}, &TrueMotion::time);
  if (next == motion.end()) return std::nullopt;
  if (next->time == time) return *next;
  if (next == motion.begin()) return std::nullopt;
  const TrueMotion& before = *std::prev(next);
  if (next->time - before.time > recording.pairing.longest_gap) return std::nullopt;
  const double part = to_seconds(time - before.time) / to_seconds(next->time - before.time);
  const auto between = [&](const Eigen::Vector3d TrueMotion::*vector) -> Eigen::Vector3d {
    return before.*vector + part * ((*next).*vector - before.*vector);
  };
  return TrueMotion{.time = time,
                    .v_world = between(&TrueMotion::v_world),
                    .accelerometer_bias = between(&TrueMotion::accelerometer_bias),
                    .gyroscope_bias = between(&TrueMotion::gyroscope_bias)};
}

InertialStart true_start(const Recording& recording) {
  if (recording.truth.empty()) {
    throw InputError("recording '" + recording.name + "' has no truth");
  }
  for (std::size_t i = 0; i < frame_count(recording); ++i) {
    const Time time = frame_time(recording, i);
    const auto pose = true_pose_at(recording, time);
    if (!pose) continue;
    const auto known = true_motion_at(recording, time);
    return {.time = time,
            .nav_T_imu = *pose,
            .v_nav = known ? known->v_world : slope(recording.truth, time)};
  }
  throw InputError("recording '" + recording.name +
                   "' has no frame at whose time its truth is known");
}

double state_nees(const std::string& chart, const Recording& recording, const Estimate& e) {
  const auto known = true_motion_at(recording, e.time);
  const auto pose = true_pose_at(recording, e.time);
  if (!known || !pose) return kNaN;
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
