#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/filter/textbook_motion_testing.hpp>
#include <chasles/velocity/body_velocity_model.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

using ErrorChartTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, ErrorChartTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

std::vector<test::StateShape> shapes() {
  std::vector<test::StateShape> result;
  for (const bool velocity : {false, true}) {
    for (const int additive : {0, 1, 10}) {
      result.push_back({.velocity = velocity, .additive = additive, .landmarks = 0, .gap = 0});
      result.push_back({.velocity = velocity, .additive = additive, .landmarks = 1, .gap = 0});
      result.push_back({.velocity = velocity, .additive = additive, .landmarks = 5, .gap = 3});
    }
    for (const bool nav : {false, true}) {
      result.push_back({.velocity = velocity,
                        .additive = 6,
                        .landmarks = 5,
                        .gap = nav ? 3 : 0,
                        .nav = nav,
                        .clones = 3,
                        .anchored = true});
      result.push_back(
          {.velocity = velocity, .additive = 6, .landmarks = 1, .nav = nav, .clones = 3});
    }
  }
  return result;
}

// Calls check(random state, random numbers) for states of every shape.
template <typename Check>
void for_each_state(Check check) {
  test::Random random(17);
  for (const test::StateShape& shape : shapes()) {
    SCOPED_TRACE(::testing::Message()
                 << "velocity " << shape.velocity << " additive " << shape.additive << " landmarks "
                 << shape.landmarks << " nav " << shape.nav << " clones " << shape.clones);
    check(test::random_state(random, shape), random);
  }
}

// An error whose rotations have this angle; zero in rows that belong to no landmark.
VectorXd error_of(const State& x, test::Random& random, double angle, double size) {
  const int rows = test::error_rows(x);
  VectorXd xi = VectorXd::Zero(rows);
  xi.head(x.core_size()) = size * random.normal_vector(x.core_size());
  for (const Landmark& landmark : x.landmarks) {
    xi.segment<3>(landmark.row) = size * random.normal_vector(3);
  }
  xi.head<3>() = angle * random.axis();
  if (x.nav_T_world) xi.segment<3>(x.nav_row()) = angle * random.axis();
  for (const Clone& clone : x.clones) {
    xi.segment<3>(clone.row) = angle * random.axis();
    xi.segment<3>(clone.row + 3) = size * random.normal_vector(3);
  }
  return xi;
}

TEST_P(ErrorChartTest, ZeroErrorMovesNothing) {
  for_each_state([&](const State& x, test::Random&) {
    const State y = test::moved(chart(), x, VectorXd::Zero(test::error_rows(x)));
    EXPECT_LT(test::distance(x, y), 1e-14);
  });
}

TEST_P(ErrorChartTest, LocalFindsTheErrorThatRetractApplied) {
  for_each_state([&](const State& x, test::Random& random) {
    for (const double angle : test::angles_below_pi()) {
      SCOPED_TRACE(angle);
      const VectorXd xi = error_of(x, random, angle, angle);
      const VectorXd found = local(chart(), x, test::moved(chart(), x, xi));
      // Positions of 50 m carry an error of 1e-14; near half a turn the axis loses digits.
      EXPECT_TRUE(test::agree(found, xi, 1e-12));
    }
  });
}

TEST_P(ErrorChartTest, RetractReachesTheStateThatLocalPointsTo) {
  for_each_state([&](const State& x, test::Random& random) {
    const State y = test::moved(kStandardChart, x, error_of(x, random, 2.5, 10));
    EXPECT_LT(test::distance(test::moved(chart(), x, local(chart(), x, y)), y), 1e-11);
  });
}

TEST_P(ErrorChartTest, PullUndoesPush) {
  for_each_state([&](const State& x, test::Random& random) {
    MatrixXd M(test::error_rows(x), 4);
    for (int j = 0; j < 4; ++j) M.col(j) = random.normal_vector(M.rows());
    const MatrixXd original = M;
    push(chart(), x, M);
    pull(chart(), x, M);
    EXPECT_TRUE(test::agree(M, original, 1e-13));
    pull(chart(), x, M);
    push(chart(), x, M);
    EXPECT_TRUE(test::agree(M, original, 1e-12));
  });
}

TEST_P(ErrorChartTest, PushIsTheDerivativeOfTheCoordinatesByTheStandardOnes) {
  for_each_state([&](const State& x, test::Random&) {
    const int n = test::error_rows(x);
    const auto coordinates = [&](const VectorXd& e) {
      return local(chart(), x, test::moved(kStandardChart, x, e));
    };
    MatrixXd expected = test::numeric_derivative(coordinates, VectorXd::Zero(n));
    for (int row = x.core_size(); row < n; ++row) {
      if (expected.row(row).isZero(0)) expected(row, row) = 1;  // belongs to no landmark
    }
    MatrixXd T = MatrixXd::Identity(n, n);
    push(chart(), x, T);
    EXPECT_TRUE(test::agree(T, expected, 1e-9));
  });
}

TEST_P(ErrorChartTest, RotationIsTheReferencesWhereLandmarksTurnWithIt) {
  if (!chart().landmark_block) return;
  for_each_state([&](const State& x, test::Random&) {
    const MatrixXd rows = chart().motion_block(x).topRows<3>();
    EXPECT_EQ(rows, MatrixXd::Identity(3, 9));
  });
}

TEST_P(ErrorChartTest, TransitionSeenInTheChartIsTheDerivativeInItsOwnCoordinates) {
  test::Random random(5);
  const test::Inertial model;
  const State x = test::random_state(random, {true, 6, 3, 0});
  const test::InertialSample u{.f_imu = random.normal_vector(3), .w_imu = random.normal_vector(3)};
  const State next = model.step(x, u, 0.1);
  const auto mapped = [&](const VectorXd& xi) {
    return local(chart(), next, model.step(test::moved(chart(), x, xi), u, 0.1));
  };
  const int n = test::error_rows(x);
  MatrixXd F = MatrixXd::Identity(n, n);
  F.topLeftCorner(x.core_size(), x.core_size()) = model.predict(x, u, 0.1).F;
  EXPECT_TRUE(test::agree(in_chart(chart(), F, x, next),
                          test::numeric_derivative(mapped, VectorXd::Zero(n)), 1e-9));
}

// F of the whole state for a step without bias, in the coordinates of the chart.
MatrixXd body_velocity_transition(const ErrorChart& chart, const State& x) {
  const BodyVelocityModel model{.velocity_state = false, .gyro_bias = false, .scale = false};
  const BodyVelocity u{.time = {}, .linear_imu = {9, 0.4, -0.2}, .angular_imu = {0.1, -0.2, 0.8}};
  const Prediction step = predict(model, x, u, 0.2, {});
  State next = x;
  next.world_T_imu = step.world_T_imu;
  MatrixXd F = MatrixXd::Identity(test::error_rows(x), test::error_rows(x));
  F.topLeftCorner<6, 6>() = step.F;
  return in_chart(chart, F, x, next);
}

TEST(RightSen3Chart, TransitionOfBodyVelocitiesDoesNotDependOnTheEstimate) {
  test::Random random(3);
  const test::StateShape shape{.velocity = false, .additive = 0, .landmarks = 4, .gap = 0};
  const State x = test::random_state(random, shape);
  const State y = test::random_state(random, shape);
  EXPECT_TRUE(test::agree(body_velocity_transition(kRightSen3Chart, x),
                          body_velocity_transition(kRightSen3Chart, y), 1e-12));
  EXPECT_FALSE(test::agree(body_velocity_transition(kStandardChart, x),
                           body_velocity_transition(kStandardChart, y), 1e-3));
}

TEST(RightSen3Chart, InertialTransitionDependsOnTheEstimateInTheBiasColumnsAlone) {
  test::Random random(4);
  const test::Inertial model;
  const test::InertialSample u{.f_imu = random.normal_vector(3), .w_imu = random.normal_vector(3)};
  const auto transition = [&](const ErrorChart& chart) {
    const State x = test::random_state(random, {true, 6, 0, 0});
    return in_chart(chart, model.predict(x, u, 0.1).F, x, model.step(x, u, 0.1));
  };
  const auto spread = [&](const ErrorChart& chart) {
    return MatrixXd(transition(chart) - transition(chart)).leftCols<9>().cwiseAbs().maxCoeff();
  };
  EXPECT_LT(spread(kRightSen3Chart), 1e-12);
  for (const ErrorChart* other : {&kStandardChart, &kLeftSe3Chart, &kRightSe3Chart}) {
    EXPECT_GT(spread(*other), 1e-3) << other->name;
  }
}

TEST(ErrorCharts, AreFoundByNameAndHaveDifferentNames) {
  for (const ErrorChart& chart : error_charts()) {
    EXPECT_EQ(&error_chart(chart.name), &chart);
    EXPECT_FALSE(chart.summary.empty());
  }
}

TEST(ErrorCharts, UnknownNameIsRejectedWithTheNamesThatThereAre) {
  try {
    error_chart("left");
    FAIL() << "nothing was thrown";
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("'left'"), std::string::npos);
    for (const ErrorChart& chart : error_charts()) {
      EXPECT_NE(text.find(chart.name), std::string::npos) << text;
    }
  }
}

}  // namespace
}  // namespace chasles
