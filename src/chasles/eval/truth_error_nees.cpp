#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/eval/truth_error_model.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr double kLeastShare = 0.1;  // of the degrees of freedom, below which nothing is left

// The squares of one kind of error, and what is expected of them.
struct Squares {
  std::vector<double>* values;
  double expected = 0, dof = 0, count = 0;

  // `before`: without marginalisation, NaN where the covariance is singular. `rest`: the expected
  // covariance of the error after the fit.
  void add(double before, const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance,
           const Eigen::MatrixXd& rest) {
    const double square = std::isnan(before) ? kNaN : normalised_square(error, covariance);
    values->push_back(square);
    if (std::isnan(square)) return;
    expected += Eigen::LLT<Eigen::MatrixXd>(covariance).solve(rest).trace();
    dof += static_cast<double>(error.size());
    ++count;
  }

  // Divides by the expected share, and returns the other one.
  double account() const {
    const double share = dof > 0 ? expected / dof : 1;
    for (double& value : *values) value = share < kLeastShare ? kNaN : value / share;
    return 1 - share;
  }
};

// A pose after the fit, in coordinates of the error.
struct FittedPose {
  Vector6d error;
  Matrix6d covariance, rest;  // marginalised; expected of the error
};

FittedPose fitted_pose(const Matrix6d& P, const Matrix67d& A, const TruthErrorFit& fit,
                       const Vector6d& error, const Matrix6d& map) {
  const Matrix6d sum = P + A * fit.robust_covariance * A.transpose();
  const Matrix6d rest = P - A * fit.covariance * A.transpose() / fit.variance_factor;
  return {.error = error, .covariance = congruence(map, sum), .rest = congruence(map, rest)};
}

struct AllSquares {
  Squares position, attitude, pose;

  void add(const PoseNees& before, const FittedPose& fitted) {
    const auto& [e, P, rest] = fitted;
    attitude.add(before.attitude, e.head<3>(), P.topLeftCorner<3, 3>(), rest.topLeftCorner<3, 3>());
    position.add(before.position, e.tail<3>(), P.bottomRightCorner<3, 3>(),
                 rest.bottomRightCorner<3, 3>());
    pose.add(before.pose, e, P, rest);
  }
};

}  // namespace

void add_nees(const TruthErrorModel& model, std::span<const Matrix6d> covariances,
              PoseError definition, const TruthErrorFit& fit, TruthErrors& result) {
  const Trajectory truths = model.corrected(fit.value);
  const SE3 estimate_T_truth = model.first_alignment(truths);
  const std::vector<Matrix67d> jacobians = model.jacobians(fit.value);
  Nees& nees = result.nees;
  nees.definition = definition;
  AllSquares squares{{&nees.position}, {&nees.attitude}, {&nees.pose}};
  std::vector<Vector6d> errors;
  std::vector<Matrix6d> marginalised;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const SE3& estimate = model.matched.estimate[i].pose;
    const SE3 truth = estimate_T_truth * truths[i].pose;
    const Matrix6d& P = covariances[model.matched.estimate_index[i]];
    squares.add(pose_nees(definition, truth, estimate, P),
                fitted_pose(P, jacobians[i], fit, pose_error(definition, truth, estimate),
                            pose_error_map(definition, estimate)));
    const FittedPose standard =
        fitted_pose(P, jacobians[i], fit, pose_error(PoseError::kStandard, truth, estimate),
                    Matrix6d::Identity());
    errors.push_back(standard.error);
    marginalised.push_back(standard.covariance);
    nees.times.push_back(model.matched.estimate[i].time);
  }
  result.fitted_share = {squares.position.account(), squares.attitude.account(),
                         squares.pose.account()};
  nees.position_summary = summarize_nees(nees.position, 3);
  nees.attitude_summary = summarize_nees(nees.attitude, 3);
  nees.pose_summary = summarize_nees(nees.pose, 6);
  nees.within_3_sigma = sigma_shares(errors, marginalised);
}

}  // namespace chasles
