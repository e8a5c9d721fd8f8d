#include <cmath>

#include <chasles/eval/truth_interpolation.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

InterpolationError interpolation_error(const Trajectory& estimate, const Trajectory& truth,
                                       Time gap) {
  Trajectory knots;
  for (const StampedPose& row : truth) {
    if (const auto pose = pose_at(estimate, row.time, gap)) knots.push_back({row.time, *pose});
  }
  constexpr double kRounding = 1e-6;  // [rad], [m]
  InterpolationError error;
  double compared = 0;
  for (const StampedPose& row : estimate) {
    const auto pose = pose_at(knots, row.time, gap);
    if (!pose) continue;
    const double turn = so3::log(pose->R.transpose() * row.pose.R).norm();
    const double away = (pose->p - row.pose.p).norm();
    ++compared;
    error.position += away * away;
    error.attitude += turn * turn;
    if (turn > kRounding || away > kRounding) ++error.share;
  }
  if (compared == 0) return {};
  return {.position = std::sqrt(error.position / compared),
          .attitude = std::sqrt(error.attitude / compared),
          .share = error.share / compared};
}

}  // namespace chasles
