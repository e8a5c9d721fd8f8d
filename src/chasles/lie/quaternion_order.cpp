#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>

#include <chasles/base/median.hpp>
#include <chasles/lie/quaternion_order.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

Eigen::Matrix3d as_read(const Eigen::Matrix3d& R) { return R; }

// Eigen's constructor takes w first.
Eigen::Matrix3d read_w_first(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix();
}

double error_with(const std::vector<TwoTurns>& turns,
                  const std::function<Eigen::Matrix3d(const Eigen::Matrix3d&)>& read) {
  std::vector<Eigen::Vector3d> errors;
  for (const TwoTurns& turn : turns) {
    const Eigen::Matrix3d a_R_b = read(turn.world_R_a).transpose() * read(turn.world_R_b);
    errors.push_back(so3::log(a_R_b * turn.a_R_b.transpose()));
  }
  Eigen::Vector3d common;
  std::vector<double> values(errors.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(errors, values.begin(), [axis](const auto& e) { return e[axis]; });
    common[axis] = median(values);
  }
  std::ranges::transform(errors, values.begin(),
                         [&](const auto& e) { return (e - common).norm(); });
  return median(values);
}

}  // namespace

TurnErrors turn_errors(const std::vector<TwoTurns>& turns) {
  return {.as_read = error_with(turns, as_read), .w_first = error_with(turns, read_w_first)};
}

}  // namespace chasles
