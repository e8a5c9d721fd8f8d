#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/lie/quaternion_order.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// Turns of a swinging body by a source with a constant bias, which is known to 0.01 rad.
std::vector<TwoTurns> turns(bool w_first) {
  const auto attitude = [](double t) {
    return so3::exp({0.5 * std::sin(0.7 * t), 0.4 * std::sin(1.1 * t), 0.3 * t});
  };
  const auto written = [&](double t) -> Eigen::Matrix3d {
    const Eigen::Quaterniond q(attitude(t));
    if (!w_first) return q.toRotationMatrix();
    return Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();  // read as x, y, z, w
  };
  std::vector<TwoTurns> result;
  for (double t = 0; t < 20; t += 0.5) {
    const Eigen::Matrix3d turn = attitude(t).transpose() * attitude(t + 1);
    result.push_back({written(t), written(t + 1), turn * so3::exp({0.05, 0.02, 0.08})});
  }
  return result;
}

TEST(QuaternionOrder, IsFoundByTurnsOfAnotherSource) {
  const TurnErrors right = turn_errors(turns(false)), wrong = turn_errors(turns(true));
  EXPECT_LT(right.as_read, 0.03);
  EXPECT_GT(wrong.as_read, 0.2);
  EXPECT_LT(wrong.w_first, 0.03);
}

TEST(QuaternionOrder, AtAStandstillBothReadingsFit) {
  const Eigen::Matrix3d R = so3::exp({0.3, -0.2, 1});
  const TurnErrors errors = turn_errors({10, {R, R, Eigen::Matrix3d::Identity()}});
  EXPECT_LT(errors.as_read, 1e-9);
  EXPECT_LT(errors.w_first, 1e-9);
}

}  // namespace
}  // namespace chasles
