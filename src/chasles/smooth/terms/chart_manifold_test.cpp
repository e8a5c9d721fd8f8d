#include <array>

#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;
using test::agree;
using test::Random;
using Numbers = Eigen::Matrix<double, kMotionNumbers, 1>;
using MotionErrors = Eigen::Matrix<double, kMotionErrors, 1>;

Numbers random_numbers(Random& random) {
  Numbers x;
  write_motion(
      {.world_T_imu = {.R = so3::exp(random.normal_vector(3)), .p = 10 * random.normal_vector(3)},
       .v_world = 3 * random.normal_vector(3)},
      x.data());
  return x;
}

Numbers plus(const ChartManifold& manifold, const Numbers& x, const MotionErrors& e) {
  Numbers y;
  manifold.Plus(x.data(), e.data(), y.data());
  return y;
}

class ChartManifolds : public test::OverCharts {};

TEST_P(ChartManifolds, MinusIsTheInverseOfPlus) {
  Random random(1);
  const ChartManifold manifold(chart());
  for (int trial = 0; trial < 50; ++trial) {
    const Numbers x = random_numbers(random);
    const MotionErrors e = 0.7 * random.normal_vector(kMotionErrors);
    const Numbers y = plus(manifold, x, e);
    MotionErrors back;
    manifold.Minus(y.data(), x.data(), back.data());
    EXPECT_TRUE(agree(back, e, 1e-11));
    EXPECT_TRUE(agree(plus(manifold, x, MotionErrors::Zero()), x, 1e-14));
  }
}

// The product that Ceres forms with a cost function's derivative by the reference chart.
TEST_P(ChartManifolds, JacobiansTurnTheReferenceChartsDerivativesIntoTheCharts) {
  Random random(2);
  const ChartManifold manifold(chart());
  const ChartManifold reference(kStandardChart);
  for (int trial = 0; trial < 20; ++trial) {
    const Numbers x = random_numbers(random);
    const Eigen::MatrixXd by_reference = test::numeric_derivative(
        [&](const MotionErrors& e) -> Eigen::VectorXd { return plus(reference, x, e); },
        MotionErrors(MotionErrors::Zero()));
    const Eigen::MatrixXd by_chart = test::numeric_derivative(
        [&](const MotionErrors& e) -> Eigen::VectorXd { return plus(manifold, x, e); },
        MotionErrors(MotionErrors::Zero()));
    Eigen::Matrix<double, kMotionNumbers, kMotionErrors, Eigen::RowMajor> J;
    manifold.PlusJacobian(x.data(), J.data());
    Eigen::Matrix<double, kMotionErrors, kMotionNumbers, Eigen::RowMajor> back;
    manifold.MinusJacobian(x.data(), back.data());
    Eigen::MatrixXd in_numbers = Eigen::MatrixXd::Zero(kMotionNumbers, kMotionNumbers);
    in_numbers.leftCols<kMotionErrors>() = by_reference;
    EXPECT_TRUE(agree(Eigen::MatrixXd(in_numbers * J), by_chart, 1e-8));
    EXPECT_TRUE(agree(Eigen::MatrixXd(back * J), Eigen::MatrixXd::Identity(9, 9), 1e-12));
  }
}

// For a pose alone: the same errors without the velocity.
TEST_P(ChartManifolds, OfAPoseAlone) {
  Random random(3);
  const ChartManifold whole(chart()), alone(chart(), false);
  for (int trial = 0; trial < 20; ++trial) {
    const Numbers x = random_numbers(random);
    MotionErrors e = 0.7 * random.normal_vector(kMotionErrors);
    Eigen::Matrix<double, kPoseNumbers, 1> y;
    alone.Plus(x.data(), e.data(), y.data());
    EXPECT_TRUE(agree(y, plus(whole, x, e).head<kPoseNumbers>(), 1e-13));
    Eigen::Matrix<double, kPoseErrors, 1> back;
    alone.Minus(y.data(), x.data(), back.data());
    EXPECT_TRUE(agree(back, e.head<kPoseErrors>(), 1e-11));
    Eigen::Matrix<double, kMotionNumbers, kMotionErrors, Eigen::RowMajor> all;
    Eigen::Matrix<double, kPoseNumbers, kPoseErrors, Eigen::RowMajor> J;
    Eigen::Matrix<double, kPoseErrors, kPoseNumbers, Eigen::RowMajor> inverse;
    whole.PlusJacobian(x.data(), all.data());
    alone.PlusJacobian(x.data(), J.data());
    alone.MinusJacobian(x.data(), inverse.data());
    EXPECT_TRUE(agree(J.topRows<6>(), all.topLeftCorner(6, 6), 1e-12));
    EXPECT_TRUE(agree(Eigen::MatrixXd(inverse * J), Eigen::MatrixXd::Identity(6, 6), 1e-12));
  }
}

INSTANTIATE_TEST_SUITE_P(Charts, ChartManifolds, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

}  // namespace
}  // namespace chasles
