#include <chasles/lie/se3.hpp>
#include <chasles/lie/series.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kRoundOff = 1e-14;

Eigen::Matrix4d matrix(const SE3& X) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = X.R;
  m.topRightCorner<3, 1>() = X.p;
  return m;
}

Eigen::Matrix4d wedge(const Vector6d& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = hat(xi.head<3>());
  m.topRightCorner<3, 1>() = xi.tail<3>();
  return m;
}

// The adjoint representation of a twist: [xi, eta] = curly(xi) eta.
Matrix6d curly(const Vector6d& xi) {
  Matrix6d m;
  m << hat(xi.head<3>()), Eigen::Matrix3d::Zero(), hat(xi.tail<3>()), hat(xi.head<3>());
  return m;
}

// Calls check(xi) over the grid of angles, directions, and translations from 0 to a kilometre.
template <typename Check>
void for_each_twist(const std::vector<double>& angles, Check check) {
  test::Random random(5);
  for (const Eigen::Vector3d& axis : test::axes()) {
    for (const double angle : angles) {
      for (const double length : {0.0, 1.0, 1000.0}) {
        SCOPED_TRACE(::testing::Message()
                     << "angle " << angle << " axis " << axis.transpose() << " length " << length);
        Vector6d xi;
        xi << angle * axis, length * random.axis();
        check(xi);
      }
    }
  }
}

SE3 random_pose(test::Random& random) {
  return {so3::exp(random.normal_vector(3)), 10 * random.normal_vector(3)};
}

TEST(Se3, ProductAndInverseAreThoseOfTheMatrices) {
  test::Random random(6);
  const SE3 A = random_pose(random);
  const SE3 B = random_pose(random);
  const Eigen::Vector3d point = random.normal_vector(3);
  EXPECT_TRUE(test::agree(matrix(A * B), matrix(A) * matrix(B), kRoundOff));
  EXPECT_TRUE(test::agree(matrix(A.inverse()) * matrix(A), Eigen::Matrix4d::Identity(), kRoundOff));
  EXPECT_TRUE(test::agree((A * B) * point, A * (B * point), kRoundOff));
}

TEST(Se3, ExpIsThePowerSeries) {
  for_each_twist(test::angles(), [](const Vector6d& xi) {
    EXPECT_TRUE(test::agree(matrix(se3::exp(xi)), test::series(wedge(xi), 0), kRoundOff));
  });
}

TEST(Se3, LogInvertsExp) {
  for_each_twist(test::angles_below_pi(), [](const Vector6d& xi) {
    const Vector6d back = se3::log(se3::exp(xi));
    EXPECT_TRUE(test::agree(back.head<3>(), xi.head<3>(), kRoundOff, 1e-300));
    EXPECT_TRUE(test::agree(back, xi, kRoundOff));
  });
}

TEST(Se3, AdjointMovesATwistThroughATransform) {
  test::Random random(7);
  for_each_twist({0, 1e-6, 0.3, 2}, [&](const Vector6d& xi) {
    const SE3 X = random_pose(random);
    const SE3 expected = X * se3::exp(xi) * X.inverse();
    EXPECT_TRUE(
        test::agree(matrix(se3::exp(se3::adjoint(X) * xi)), matrix(expected), 4 * kRoundOff));
  });
}

TEST(Se3, AdjointOfAnExponentialIsTheExponentialOfTheAdjoint) {
  for_each_twist(test::angles(), [](const Vector6d& xi) {
    EXPECT_TRUE(test::agree(se3::adjoint(se3::exp(xi)), test::series(curly(xi), 0), 2 * kRoundOff));
  });
}

TEST(Se3, JacobiansAreThePowerSeriesOfTheAdjointRepresentation) {
  for_each_twist(test::angles(), [](const Vector6d& xi) {
    EXPECT_TRUE(test::agree(se3::left_jacobian(xi), test::series(curly(xi), 1), kRoundOff));
    EXPECT_TRUE(test::agree(se3::right_jacobian(xi), test::series(-curly(xi), 1), kRoundOff));
  });
}

TEST(Se3, LeftJacobianIsThePerturbationOnTheLeft) {
  test::Random random(8);
  for (const double angle : test::angles()) {
    Vector6d xi;
    xi << angle * random.axis(), random.normal_vector(3);
    const SE3 X = se3::exp(xi);
    const auto left = [&](const Vector6d& d) { return se3::log(se3::exp(xi + d) * X.inverse()); };
    const auto right = [&](const Vector6d& d) { return se3::log(X.inverse() * se3::exp(xi + d)); };
    const Vector6d zero = Vector6d::Zero();
    EXPECT_TRUE(test::agree(se3::left_jacobian(xi), test::numeric_derivative(left, zero), 1e-11));
    EXPECT_TRUE(test::agree(se3::right_jacobian(xi), test::numeric_derivative(right, zero), 1e-11));
  }
}

TEST(Se3, InverseJacobiansAreTheInverses) {
  for_each_twist(test::angles(), [](const Vector6d& xi) {
    const Eigen::MatrixXd left = test::inverse(test::series(curly(xi), 1));
    EXPECT_TRUE(test::agree(se3::left_jacobian_inverse(xi), left, 10 * kRoundOff));
    const Eigen::MatrixXd right = test::inverse(test::series(-curly(xi), 1));
    EXPECT_TRUE(test::agree(se3::right_jacobian_inverse(xi), right, 10 * kRoundOff));
  });
}

}  // namespace
}  // namespace chasles
