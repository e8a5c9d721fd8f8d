#include <cmath>

#include <chasles/base/error.hpp>
#include <chasles/filter/first_order_transition.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;

/// The paper's three charts.
class FirstOrder : public test::OverCharts {};
INSTANTIATE_TEST_SUITE_P(Charts, FirstOrder,
                         ::testing::Values(&kStandardChart, &kLeftSe3Chart, &kRightSe3Chart),
                         test::chart_test_name);

State start_of(test::Random& random) {
  return test::random_state(random, {.velocity = true, .additive = 6, .nav = true});
}

InertialModel first_order_in(const ErrorChart& chart) {
  InertialModel model = test::inertial_model_askew();
  model.first_order = &chart;
  return model;
}

/// One interval of this length through both transitions, in the coordinates of the chart.
struct Transitions {
  MatrixXd exact, first_order, exact_noise, first_order_noise;
};

Transitions both(const ErrorChart& chart, const State& x, double tau) {
  const ImuInterval interval{.tau = tau,
                             .specific_force_imu = {0.4, -0.7, 9.5},
                             .angular_rate_imu = {0.5, -1.1, 0.8},
                             .noise_scale = 2,
                             .accelerometer_extra_density = 0.03,
                             .gyroscope_extra_density = 0.004};
  const Prediction exact = predict(test::inertial_model_askew(), x, {&interval, 1});
  const Prediction first = predict(first_order_in(chart), x, {&interval, 1});
  const State next = test::predicted(x, exact);
  EXPECT_EQ(test::distance(next, test::predicted(x, first)), 0) << "the mean is the same";
  MatrixXd T = MatrixXd::Identity(x.size(), x.size());
  push(chart, next, T);
  return {.exact = in_chart(chart, exact.F, x, next),
          .first_order = in_chart(chart, first.F, x, next),
          .exact_noise = T * exact.Q * T.transpose(),
          .first_order_noise = T * first.Q * T.transpose()};
}

double difference(const MatrixXd& a, const MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

// The error of a step to first order is of second order: half the interval, a quarter of it.
TEST_P(FirstOrder, TransitionDiffersFromTheExactOneByTheSquareOfTheInterval) {
  test::Random random(5);
  for (int i = 0; i < 5; ++i) {
    const State x = start_of(random);
    const Transitions coarse = both(chart(), x, 4e-3), fine = both(chart(), x, 2e-3);
    const double error = difference(coarse.exact, coarse.first_order);
    EXPECT_GT(error, 1e-7) << "it is not the exact one";
    EXPECT_NEAR(error / difference(fine.exact, fine.first_order), 4, 0.2);
  }
}

// In units of the exact standard deviations, so that every part of the noise counts.
TEST_P(FirstOrder, NoiseDiffersFromTheExactOneBelowItsLeadingOrder) {
  test::Random random(6);
  const State x = start_of(random);
  // Without the position, whose noise is of higher order in the interval, and nav_T_world.
  std::vector<int> rows{0, 1, 2, 6, 7, 8};
  for (int i = 0; i < 6; ++i) rows.push_back(x.additive_row() + i);
  const auto relative = [&](double tau) {
    const Transitions t = both(chart(), x, tau);
    const MatrixXd exact = t.exact_noise(rows, rows), first = t.first_order_noise(rows, rows);
    return test::covariance_difference(first, exact);
  };
  EXPECT_LT(relative(1e-3), 0.02);
  EXPECT_NEAR(relative(1e-3) / relative(5e-4), 2, 0.4);
}

TEST_P(FirstOrder, IntervalsAreMultiplied) {
  test::Random random(7);
  const State x = start_of(random);
  const std::vector<ImuInterval> intervals = test::imu_intervals(random, 4);
  const InertialModel model = first_order_in(chart());
  const Prediction whole = predict(model, x, intervals);
  State at = x;
  MatrixXd F = MatrixXd::Identity(x.size(), x.size()), Q = MatrixXd::Zero(x.size(), x.size());
  for (const ImuInterval& interval : intervals) {
    const Prediction step = predict(model, at, {&interval, 1});
    at = test::predicted(at, step);
    F = step.F * F;
    Q = step.F * Q * step.F.transpose() + step.Q;
  }
  EXPECT_TRUE(test::agree(whole.F, F, 1e-12));
  EXPECT_TRUE(test::agree(whole.Q, Q, 1e-12, 0));
}

TEST(FirstOrderTransition, IsNotForTheFourthChart) {
  test::Random random(8);
  const ImuInterval interval{.tau = 0.01};
  EXPECT_THROW(predict(first_order_in(kRightSen3Chart), start_of(random), {&interval, 1}),
               UsageError);
}

}  // namespace
}  // namespace chasles
