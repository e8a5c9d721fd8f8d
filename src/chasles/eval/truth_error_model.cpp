#include <algorithm>

#include <chasles/eval/alignment.hpp>
#include <chasles/eval/truth_error_model.hpp>

namespace chasles {
namespace {

constexpr double kTimeStep = 0.005, kAngleStep = 1e-3;  // of central differences [s], [rad]

// The position at a time that may be a little beyond the truth's end.
Eigen::Vector3d position_at(const TruthErrorModel& model, const StampedPose& row, double shift) {
  const auto position = [&](double by) {
    return pose_at(model.truth, row.time + from_seconds(by), model.gap);
  };
  if (shift == 0) return row.pose.p;
  // Between stamps of another pairing the row itself is not interpolated.
  const auto here = position(0), there = position(shift);
  if (here && there) return row.pose.p + there->p - here->p;
  const auto opposite = position(-shift);
  if (here && opposite) return row.pose.p + here->p - opposite->p;
  return row.pose.p;
}

}  // namespace

TruthConstants TruthConstants::from(const Vector7d& vector) {
  return {.position_time = vector[0], .body = vector.segment<3>(1), .world = vector.tail<3>()};
}

Trajectory TruthErrorModel::corrected(const Vector7d& constants) const {
  const auto [time, body, world] = TruthConstants::from(constants);
  const Eigen::Matrix3d before = so3::exp(world), after = so3::exp(body);
  Trajectory result = matched.truth;
  for (StampedPose& row : result) {
    row.pose = {before * row.pose.R * after, position_at(*this, row, time)};
  }
  return result;
}

SE3 TruthErrorModel::first_alignment(const Trajectory& corrected) const {
  const MatchedTrajectories first{
      .estimate = {matched.estimate.front()}, .truth = {corrected.front()}, .estimate_index = {0}};
  return align(first, level ? Alignment::kFirstLevel : Alignment::kFirstPose)
      .truth_T_estimate.inverse();
}

std::vector<Vector6d> TruthErrorModel::errors(const Vector7d& constants) const {
  const Trajectory truths = corrected(constants);
  const SE3 estimate_T_truth = first_alignment(truths);
  std::vector<Vector6d> result;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    result.push_back(pose_error(PoseError::kStandard, estimate_T_truth * truths[i].pose,
                                matched.estimate[i].pose));
  }
  return result;
}

std::vector<Matrix67d> TruthErrorModel::jacobians(const Vector7d& constants) const {
  std::vector<Matrix67d> result(matched.truth.size());
  for (Eigen::Index k = 0; k < 7; ++k) {
    Vector7d step = Vector7d::Zero();
    step[k] = k == 0 ? kTimeStep : kAngleStep;
    const std::vector<Vector6d> more = errors(constants + step), less = errors(constants - step);
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i].col(k) = (more[i] - less[i]) / (2 * step[k]);
    }
  }
  return result;
}

}  // namespace chasles
