#include <numbers>

#include <Eigen/Geometry>

#include <chasles/lie/series.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kSo3RoundOff = 4e-15;

// Calls check(phi) for every direction and angle.
template <typename Check>
void for_each_rotation(const std::vector<double>& angles, Check check) {
  for (const Eigen::Vector3d& axis : test::axes()) {
    for (const double angle : angles) {
      SCOPED_TRACE(::testing::Message() << "angle " << angle << " axis " << axis.transpose());
      check(Eigen::Vector3d(angle * axis));
    }
  }
}

TEST(So3, HatIsTheCrossProduct) {
  test::Random random(1);
  const Eigen::Vector3d a = random.normal_vector(3);
  const Eigen::Vector3d b = random.normal_vector(3);
  EXPECT_TRUE(test::agree(hat(a) * b, a.cross(b), kSo3RoundOff));
}

TEST(So3, ExpIsThePowerSeries) {
  for_each_rotation(test::angles(), [](const Eigen::Vector3d& phi) {
    EXPECT_TRUE(test::agree(so3::exp(phi), test::series(hat(phi), 0), kSo3RoundOff));
  });
}

TEST(So3, ExpIsARotation) {
  for_each_rotation(test::angles(), [](const Eigen::Vector3d& phi) {
    const Eigen::Matrix3d R = so3::exp(phi);
    EXPECT_TRUE(test::agree(R * R.transpose(), Eigen::Matrix3d::Identity(), kSo3RoundOff));
    EXPECT_GT(R.determinant(), 0);
  });
}

TEST(So3, LogInvertsExpToTheLastDigitsOfTheAngle) {
  for_each_rotation(test::angles_below_pi(), [](const Eigen::Vector3d& phi) {
    EXPECT_TRUE(test::agree(so3::log(so3::exp(phi)), phi, kSo3RoundOff, 1e-300));
  });
}

TEST(So3, LogOfHalfATurnIsOneOfItsTwoAxes) {
  for (const Eigen::Vector3d& axis : test::axes()) {
    const Eigen::Vector3d phi = so3::log(2 * axis * axis.transpose() - Eigen::Matrix3d::Identity());
    EXPECT_NEAR(phi.norm(), std::numbers::pi, kSo3RoundOff);
    EXPECT_NEAR(std::abs(phi.normalized().dot(axis)), 1, kSo3RoundOff);
  }
}

TEST(So3, LogPastHalfATurnIsTheShortWayRound) {
  for (const Eigen::Vector3d& axis : test::axes()) {
    const Eigen::Vector3d expected = (5.0 - 2 * std::numbers::pi) * axis;
    EXPECT_TRUE(test::agree(so3::log(so3::exp(5.0 * axis)), expected, kSo3RoundOff));
  }
}

TEST(So3, JacobiansAndGamma2AreTheirPowerSeries) {
  for_each_rotation(test::angles(), [](const Eigen::Vector3d& phi) {
    EXPECT_TRUE(test::agree(so3::left_jacobian(phi), test::series(hat(phi), 1), kSo3RoundOff));
    EXPECT_TRUE(test::agree(so3::right_jacobian(phi), test::series(-hat(phi), 1), kSo3RoundOff));
    EXPECT_TRUE(test::agree(so3::gamma2(phi), test::series(hat(phi), 2), kSo3RoundOff));
  });
}

TEST(So3, SmallAnglesKeepTheirFirstOrderTerms) {
  for (const double angle : {1e-12, 1e-8, 1e-6, 1e-4}) {
    const Eigen::Vector3d phi = angle * Eigen::Vector3d(1, -2, 3).normalized();
    const Eigen::Matrix3d linear = so3::left_jacobian(phi) - so3::right_jacobian(phi);
    EXPECT_TRUE(test::agree(linear, hat(phi), 1e-8 + 1e-15 / angle, 1e-300));
  }
}

TEST(So3, LeftJacobianIsThePerturbationOnTheLeft) {
  for_each_rotation(test::angles(), [](const Eigen::Vector3d& phi) {
    const auto left = [&](const Eigen::Vector3d& d) {
      return so3::log(so3::exp(phi + d) * so3::exp(phi).transpose());
    };
    const auto right = [&](const Eigen::Vector3d& d) {
      return so3::log(so3::exp(phi).transpose() * so3::exp(phi + d));
    };
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    EXPECT_TRUE(test::agree(so3::left_jacobian(phi), test::numeric_derivative(left, zero), 1e-11));
    EXPECT_TRUE(
        test::agree(so3::right_jacobian(phi), test::numeric_derivative(right, zero), 1e-11));
  });
}

TEST(So3, InverseJacobiansAreTheInverses) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  for_each_rotation(test::angles(), [&](const Eigen::Vector3d& phi) {
    const Eigen::Matrix3d left = so3::left_jacobian_inverse(phi);
    EXPECT_TRUE(test::agree(so3::left_jacobian(phi) * left, I, 10 * kSo3RoundOff));
    const Eigen::Matrix3d right = so3::right_jacobian_inverse(phi);
    EXPECT_TRUE(test::agree(right * so3::right_jacobian(phi), I, 10 * kSo3RoundOff));
  });
}

TEST(So3, InverseJacobianIsTheInverseOfTheSeries) {
  for_each_rotation(test::angles(), [](const Eigen::Vector3d& phi) {
    const Eigen::Matrix3d expected = test::inverse(test::series(hat(phi), 1));
    EXPECT_TRUE(test::agree(so3::left_jacobian_inverse(phi), expected, 10 * kSo3RoundOff));
  });
}

TEST(So3, BetweenIsTheShortestRotationFromOneDirectionToAnother) {
  test::Random random(4);
  for (const double angle : {0.0, 1e-9, 0.3, 1.5, 2.9, 3.1, std::numbers::pi - 1e-5}) {
    const Eigen::Vector3d a = random.axis(), normal = random.axis().cross(a).normalized();
    const Eigen::Matrix3d turn = so3::exp(angle * normal);
    EXPECT_TRUE(test::agree(so3::between(3 * a, 0.2 * turn * a), turn, 1e-10)) << angle;
  }
}

TEST(So3, BetweenTurnsAboutAPerpendicularWhereTheDirectionsAreOpposite) {
  test::Random random(5);
  for (const double off : {0.0, 1e-15, 1e-12, 1e-9, 1e-7}) {
    const Eigen::Vector3d a = random.axis(), b = -a + off * random.axis();
    const Eigen::Matrix3d R = so3::between(a, b);
    EXPECT_TRUE(test::agree(R * R.transpose(), Eigen::Matrix3d::Identity(), 1e-14)) << off;
    EXPECT_GT(R.determinant(), 0);
    EXPECT_TRUE(test::agree(R * a, b.normalized(), 1e-14)) << off;
  }
}

TEST(So3, NormalizedRemovesTheRoundOffOfManyProducts) {
  test::Random random(3);
  const Eigen::Matrix3d step = so3::exp(0.3 * random.axis());
  Eigen::Matrix3d R = so3::exp(random.axis());
  for (int i = 0; i < 100000; ++i) R = step * R;
  const Eigen::Matrix3d clean = so3::normalized(R);
  // Some units in the last place: how many depends on the processor.
  EXPECT_TRUE(test::agree(clean * clean.transpose(), Eigen::Matrix3d::Identity(), 4e-15));
  EXPECT_TRUE(test::agree(clean, R, 1e-10));
}

}  // namespace
}  // namespace chasles
