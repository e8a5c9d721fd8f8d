#include <chasles/report/pose_errors.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>

namespace chasles {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Truth at a time within its span.
std::optional<SE3> pose_at(const Trajectory& truth, Time time) {
  const auto later = std::lower_bound(truth.begin(), truth.end(), time,
                                      [](const StampedPose& s, Time t) { return s.time < t; });
  if (later == truth.end()) return std::nullopt;
  if (later->time == time) return later->pose;
  if (later == truth.begin()) return std::nullopt;
  const StampedPose& earlier = *std::prev(later);
  const double part = to_seconds(time - earlier.time) / to_seconds(later->time - earlier.time);
  const Vector6d screw = se3::log(earlier.pose.inverse() * later->pose);
  return earlier.pose * se3::exp(part * screw);
}

SE3 best_fit(const std::vector<RunState>& states, const std::vector<std::optional<SE3>>& truth) {
  const auto common = std::count_if(truth.begin(), truth.end(), [](auto& t) { return t; });
  Eigen::Matrix3Xd p_truth(3, common), p_world(3, common);
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (!truth[i]) continue;
    p_truth.col(column) = truth[i]->p;
    p_world.col(column++) = states[i].world_T_imu.p;
  }
  // Umeyama 1991, without scale.
  const Eigen::Matrix4d fit = Eigen::umeyama(p_truth, p_world, false);
  return {.R = fit.topLeftCorner<3, 3>(), .p = fit.topRightCorner<3, 1>()};
}

/// e' P^-1 e; NaN when P is not safely positive definite (a pose that is known by definition).
double normalised_square(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& error) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  const Eigen::VectorXd diagonal = covariance.diagonal();
  if (llt.info() != Eigen::Success || !(diagonal.minCoeff() > 1e-18)) return kNaN;
  return llt.matrixL().solve(error).squaredNorm();
}

void add_state(PoseErrors& errors, const RunState& state, const std::optional<SE3>& truth) {
  Vector6d error = Vector6d::Constant(kNaN);
  if (truth) {
    const SE3 placed = errors.world_T_truth_first * *truth;
    error << so3::log(placed.R * state.world_T_imu.R.transpose()), placed.p - state.world_T_imu.p;
  }
  const Matrix6d& P = state.pose_covariance;
  const auto nees = [&](Eigen::Index first, Eigen::Index n) {
    return truth ? normalised_square(P.block(first, first, n, n), error.segment(first, n)) : kNaN;
  };
  errors.error.push_back(error);
  errors.nees_pose.push_back(nees(0, 6));
  errors.nees_attitude.push_back(nees(0, 3));
  errors.nees_position.push_back(nees(3, 3));
}

}  // namespace

PoseErrors pose_errors(const std::vector<RunState>& states, const Trajectory& truth) {
  std::vector<std::optional<SE3>> truth_at_states;
  truth_at_states.reserve(states.size());
  for (const RunState& state : states) truth_at_states.push_back(pose_at(truth, state.time));

  PoseErrors errors;
  const auto first = std::find_if(truth_at_states.begin(), truth_at_states.end(),
                                  [](const auto& pose) { return pose.has_value(); });
  if (first != truth_at_states.end()) {
    const RunState& state = states[static_cast<std::size_t>(first - truth_at_states.begin())];
    errors.world_T_truth_first = state.world_T_imu * (*first)->inverse();
    errors.world_T_truth_fit = best_fit(states, truth_at_states);
  }
  for (std::size_t i = 0; i < states.size(); ++i) add_state(errors, states[i], truth_at_states[i]);
  return errors;
}

}  // namespace chasles
