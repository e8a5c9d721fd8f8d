#include <chasles/lie/sek3.hpp>
#include <chasles/lie/series.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kSek3RoundOff = 1e-14;

// (3+k) x (3+k): [R, x; 0, I].
Eigen::MatrixXd matrix(const SEk3& X) {
  const Eigen::Index k = X.x.cols();
  Eigen::MatrixXd m = Eigen::MatrixXd::Identity(3 + k, 3 + k);
  m.topLeftCorner<3, 3>() = X.R;
  m.topRightCorner(3, k) = X.x;
  return m;
}

Eigen::MatrixXd wedge(const Eigen::VectorXd& xi) {
  const Eigen::Index k = xi.size() / 3 - 1;
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(3 + k, 3 + k);
  m.topLeftCorner<3, 3>() = hat(xi.head<3>());
  for (Eigen::Index i = 0; i < k; ++i) m.block<3, 1>(0, 3 + i) = xi.segment<3>(3 + 3 * i);
  return m;
}

Eigen::MatrixXd curly(const Eigen::VectorXd& xi) {
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(xi.size(), xi.size());
  for (Eigen::Index i = 0; i < xi.size(); i += 3) {
    m.block<3, 3>(i, i) = hat(xi.head<3>());
    if (i > 0) m.block<3, 3>(i, 0) = hat(xi.segment<3>(i));
  }
  return m;
}

class Sek3 : public ::testing::TestWithParam<Eigen::Index> {
 protected:
  Eigen::Index k() const { return GetParam(); }

  Eigen::VectorXd tangent(double angle) {
    Eigen::VectorXd xi(3 + 3 * k());
    xi << angle * random_.axis(), 10 * random_.normal_vector(3 * k());
    return xi;
  }

  SEk3 element() { return sek3::exp(tangent(random_.uniform(0, 3))); }

  template <typename Check>
  void for_each_tangent(const std::vector<double>& angles, Check check) {
    for (const double angle : angles) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        SCOPED_TRACE(::testing::Message() << "angle " << angle);
        check(tangent(angle));
      }
    }
  }

  test::Random random_{11};
};

TEST_P(Sek3, ProductAndInverseAreThoseOfTheMatrices) {
  const SEk3 A = element();
  const SEk3 B = element();
  EXPECT_TRUE(test::agree(matrix(A * B), matrix(A) * matrix(B), kSek3RoundOff));
  EXPECT_TRUE(test::agree(matrix(A * A.inverse()), Eigen::MatrixXd::Identity(3 + k(), 3 + k()),
                          kSek3RoundOff));
}

TEST_P(Sek3, ExpIsThePowerSeries) {
  for_each_tangent(test::angles(), [](const Eigen::VectorXd& xi) {
    EXPECT_TRUE(test::agree(matrix(sek3::exp(xi)), test::series(wedge(xi), 0), kSek3RoundOff));
  });
}

TEST_P(Sek3, LogInvertsExp) {
  for_each_tangent(test::angles_below_pi(), [](const Eigen::VectorXd& xi) {
    EXPECT_TRUE(test::agree(sek3::log(sek3::exp(xi)), xi, kSek3RoundOff));
  });
}

TEST_P(Sek3, AdjointMovesATangentThroughAnElement) {
  for_each_tangent({0, 1e-6, 0.3, 2}, [&](const Eigen::VectorXd& xi) {
    const SEk3 X = element();
    const Eigen::MatrixXd moved = matrix(X * sek3::exp(xi) * X.inverse());
    EXPECT_TRUE(test::agree(matrix(sek3::exp(sek3::adjoint(X) * xi)), moved, 2 * kSek3RoundOff));
  });
}

TEST_P(Sek3, JacobiansAreThePowerSeriesOfTheAdjointRepresentation) {
  for_each_tangent(test::angles(), [](const Eigen::VectorXd& xi) {
    const Eigen::MatrixXd left = test::series(curly(xi), 1);
    const Eigen::MatrixXd right = test::series(-curly(xi), 1);
    EXPECT_TRUE(test::agree(sek3::left_jacobian(xi), left, kSek3RoundOff));
    EXPECT_TRUE(test::agree(sek3::right_jacobian(xi), right, kSek3RoundOff));
    EXPECT_TRUE(
        test::agree(sek3::left_jacobian_inverse(xi), test::inverse(left), 10 * kSek3RoundOff));
    EXPECT_TRUE(
        test::agree(sek3::right_jacobian_inverse(xi), test::inverse(right), 10 * kSek3RoundOff));
  });
}

TEST_P(Sek3, LeftJacobianIsThePerturbationOnTheLeft) {
  for (const double angle : test::angles()) {
    const Eigen::VectorXd xi = tangent(angle);
    const SEk3 X = sek3::exp(xi);
    const auto left = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return sek3::log(sek3::exp(xi + d) * X.inverse());
    };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(xi.size());
    EXPECT_TRUE(test::agree(sek3::left_jacobian(xi), test::numeric_derivative(left, zero), 1e-11));
  }
}

TEST(Sek3OfOneVector, IsSe3) {
  test::Random random(12);
  const Vector6d xi = random.normal_vector(6);
  const SE3 expected = se3::exp(xi);
  const SEk3 actual = sek3::exp(xi);
  EXPECT_TRUE(test::agree(actual.R, expected.R, 0));
  EXPECT_TRUE(test::agree(actual.x, expected.p, 1e-15));
  EXPECT_TRUE(test::agree(sek3::adjoint(actual), se3::adjoint(expected), 1e-15));
  EXPECT_TRUE(test::agree(sek3::left_jacobian(xi), se3::left_jacobian(xi), 1e-15));
}

INSTANTIATE_TEST_SUITE_P(Vectors, Sek3, ::testing::Values(1, 2, 5));

}  // namespace
}  // namespace chasles
