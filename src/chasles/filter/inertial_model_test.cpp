#include <span>

#include <Eigen/LU>

#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

using InertialModelTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, InertialModelTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

const InertialModel kModel = test::inertial_model_askew();

State some_state(test::Random& random, bool nav) {
  return test::random_state(
      random,
      {.velocity = true, .additive = 6, .landmarks = 2, .nav = nav, .clones = 1, .anchored = true});
}

TEST(InertialModel, GravityIsTurnedIntoTheWorldsAxes) {
  State x;
  EXPECT_EQ(gravity_world(InertialModel{}, x), Vector3d(0, 0, -kStandardGravity));
  x.nav_T_world = SE3{so3::exp({std::numbers::pi / 2, 0, 0}), {1, 2, 3}};  // y of the world is up
  EXPECT_TRUE(
      test::agree(gravity_world(InertialModel{}, x), Vector3d(0, -kStandardGravity, 0), 1e-15));
}

TEST_P(InertialModelTest, TransitionIsTheDerivativeOfTheMean) {
  test::Random random(1);
  for (const bool nav : {false, true}) {
    for (const int count : {1, 5}) {
      SCOPED_TRACE(::testing::Message() << "nav " << nav << " intervals " << count);
      const State x = some_state(random, nav);
      const std::vector<ImuInterval> intervals = test::imu_intervals(random, count);
      const auto after = [&](const State& from) {
        return test::predicted(from, predict(kModel, from, intervals));
      };
      const State next = after(x);
      const auto mapped = [&](const VectorXd& xi) {
        return local(chart(), next, after(test::moved(chart(), x, xi)));
      };
      const MatrixXd F = test::with_the_others(predict(kModel, x, intervals).F, x);
      EXPECT_TRUE(test::agree(in_chart(chart(), F, x, next),
                              test::numeric_derivative(mapped, VectorXd::Zero(x.size())), 1e-9));
    }
  }
}

TEST(InertialModel, ManyIntervalsAreTheProductOfSingleOnes) {
  test::Random random(2);
  for (const bool nav : {false, true}) {
    const State x = some_state(random, nav);
    const std::vector<ImuInterval> intervals = test::imu_intervals(random, 6);
    const int n = x.core_size();
    State next = x;
    MatrixXd F = MatrixXd::Identity(n, n);
    MatrixXd Q = MatrixXd::Zero(n, n);
    for (const ImuInterval& interval : intervals) {
      const Prediction step = predict(kModel, next, {&interval, 1});
      next = test::predicted(next, step);
      F = step.F * F;
      Q = step.F * Q * step.F.transpose() + step.Q;
    }
    const Prediction whole = predict(kModel, x, intervals);
    EXPECT_LT(test::distance(test::predicted(x, whole), next), 1e-13);
    EXPECT_TRUE(test::agree(whole.F, F, 1e-13));
    EXPECT_TRUE(test::agree(whole.Q, Q, 1e-13, 0));
    EXPECT_GT(Q.diagonal().minCoeff(), nav ? -1 : 0);
  }
}

TEST(InertialModel, NoIntervalChangesNothing) {
  test::Random random(3);
  const State x = some_state(random, true);
  const Prediction none = predict(kModel, x, {});
  EXPECT_EQ(test::distance(test::predicted(x, none), x), 0);
  EXPECT_TRUE(none.F.isIdentity(0));
  EXPECT_TRUE(none.Q.isZero(0));
}

// Columns and rows of the errors of some_state with nav_T_world.
enum Row { kPsi = 0, kXi = 3, kV = 6, kNav = 9, kBa = 15, kBg = 18, kZeta = 30, kRows = 33 };

// Terms of the matrices of a chart: docs/derivations.md, D19 to D22.
struct Continuous {
  MatrixXd F = MatrixXd::Zero(kRows, kRows);
  MatrixXd G = MatrixXd::Zero(kRows, 6);  // by noise of accelerometer and gyroscope

  void set(int row, int column, const Matrix3d& block) { F.block<3, 3>(row, column) = block; }
  // The column of a bias, equal to that of the sensor's noise.
  void bias(int row, int column, const Matrix3d& block) {
    set(row, column, block);
    G.block<3, 3>(row, column == kBa ? 0 : 3) = block;
  }
};

Continuous continuous(const ErrorChart& chart, const State& x, const ImuInterval& u) {
  const Matrix3d I = Matrix3d::Identity();
  const Matrix3d& C = x.world_T_imu.R;
  const Vector3d& p = x.world_T_imu.p;
  const Vector3d& v = *x.v_world;
  const Matrix3d of_nav = x.nav_T_world->R.transpose() * hat(kModel.gravity_nav);
  const Vector3d g = x.nav_T_world->R.transpose() * kModel.gravity_nav;
  const Vector3d f = u.specific_force_imu - x.additive.head<3>();
  const Vector3d w = u.angular_rate_imu - x.additive.tail<3>();
  Continuous c;
  c.set(kXi, kV, I);
  if (chart.name == "left-se3") {
    const Vector3d v_imu = C.transpose() * v;
    c.set(kXi, kXi, -hat(w));
    c.set(kXi, kPsi, -hat(v_imu));
    c.set(kV, kV, -hat(w));
    c.set(kV, kPsi, hat(C.transpose() * g));
    c.set(kV, kNav, C.transpose() * of_nav);
    c.set(kPsi, kPsi, -hat(w));
    c.bias(kV, kBa, -I);
    c.bias(kV, kBg, -hat(v_imu));
    c.bias(kPsi, kBg, -I);
    return c;
  }
  c.set(kV, kNav, of_nav);
  c.bias(kV, kBa, -C);
  c.bias(kPsi, kBg, -C);
  if (chart.name == "standard") c.set(kV, kPsi, -hat(C * f));
  if (chart.name == "right-se3") {
    c.set(kXi, kPsi, hat(v));
    c.bias(kXi, kBg, -hat(p) * C);
    c.set(kV, kPsi, -hat(C * f));
  }
  if (chart.name == "right-sen3") {
    c.bias(kXi, kBg, -hat(p) * C);
    c.set(kV, kPsi, hat(g));
    c.bias(kV, kBg, -hat(v) * C);
    c.bias(kZeta, kBg, -hat(x.landmarks[1].p_world) * C);
  }
  return c;
}

// The limit of f(tau) / tau at 0, to third order of tau.
template <typename Function>
MatrixXd rate(const Function& f) {
  constexpr double kTau = 1e-3;
  const auto D = [&](double tau) { return MatrixXd(f(tau) / tau); };
  return (D(kTau) - 14 * D(kTau / 2) + 56 * D(kTau / 4) - 64 * D(kTau / 8)) / -21;
}

// Kleinert & Stilla (23)-(29), (39)-(41) with (40'), (47)-(49), in the form of docs/derivations.md,
// D19 to D22.
TEST_P(InertialModelTest, TransitionOfAShortTimeIsThePapersMatrix) {
  test::Random random(4);
  const State x = some_state(random, true);
  ASSERT_EQ(x.size(), kRows);
  ImuInterval u = test::imu_intervals(random, 1)[0];
  u.noise_scale = 1;
  const auto step = [&](double tau) {
    u.tau = tau;
    return predict(kModel, x, {&u, 1});
  };
  const MatrixXd F = rate([&](double tau) -> MatrixXd {
    const Prediction to = step(tau);
    return in_chart(chart(), test::with_the_others(to.F, x), x, test::predicted(x, to)) -
           MatrixXd::Identity(kRows, kRows);
  });
  const Continuous expected = continuous(chart(), x, u);
  EXPECT_TRUE(test::agree(F, expected.F, 1e-8));

  const MatrixXd Q = rate([&](double tau) -> MatrixXd {
    const Prediction to = step(tau);
    const MatrixXd T = test::change_of_chart(chart(), test::predicted(x, to)).leftCols(21);
    return T * to.Q * T.transpose();
  });
  const ImuNoise noise = kModel.noise;
  VectorXd density(6);
  density << Vector3d::Constant(noise.accelerometer_noise_density),
      Vector3d::Constant(noise.gyroscope_noise_density);
  MatrixXd Q_expected = expected.G * density.cwiseAbs2().asDiagonal() * expected.G.transpose();
  Q_expected.diagonal().segment<3>(kBa).array() += std::pow(noise.accelerometer_random_walk, 2);
  Q_expected.diagonal().segment<3>(kBg).array() += std::pow(noise.gyroscope_random_walk, 2);
  EXPECT_TRUE(test::agree(Q, Q_expected, 1e-8, 0));
}

// The transitions of two states for the same samples, without the columns of the biases.
MatrixXd spread_of_transitions(const ErrorChart& chart) {
  test::Random random(5);
  const std::vector<ImuInterval> intervals = test::imu_intervals(random, 4);
  MatrixXd F[2];
  const VectorXd biases = 0.1 * random.normal_vector(6);
  for (MatrixXd& one : F) {
    State x =
        test::random_state(random, {.velocity = true, .additive = 6, .landmarks = 3, .clones = 1});
    x.additive = biases;
    const Prediction to = predict(kModel, x, intervals);
    one = in_chart(chart, test::with_the_others(to.F, x), x, test::predicted(x, to));
    one.middleCols<6>(x.additive_row()).setZero();
  }
  return F[0] - F[1];
}

TEST(InertialModel, TransitionOfTheGroupDoesNotDependOnTheEstimate) {
  EXPECT_LT(spread_of_transitions(kRightSen3Chart).cwiseAbs().maxCoeff(), 1e-12);
  for (const ErrorChart* other : {&kStandardChart, &kLeftSe3Chart, &kRightSe3Chart}) {
    EXPECT_GT(spread_of_transitions(*other).cwiseAbs().maxCoeff(), 1e-3) << other->name;
  }
}

TEST_P(InertialModelTest, MotionInNavHasTheCovarianceOfItsDerivative) {
  test::Random random(6);
  for (const bool nav : {false, true}) {
    const Ekf filter = test::inertial_filter(chart(), random, nav);
    const State& x = filter.state();
    const NavState motion = nav_state(filter);
    const auto in_nav = [&](const State& y) {
      State result;
      result.v_world = y.nav_T_world ? y.nav_T_world->R * *y.v_world : *y.v_world;
      result.additive = y.additive;
      result.world_T_imu = y.nav_T_world ? *y.nav_T_world * y.world_T_imu : y.world_T_imu;
      return result;
    };
    EXPECT_LT(test::distance(motion.nav_T_imu, in_nav(x).world_T_imu), 1e-12);
    EXPECT_LT((motion.v_nav - *in_nav(x).v_world).norm(), 1e-12);
    EXPECT_EQ(motion.biases, x.additive);
    const auto coordinates = [&](const VectorXd& e) {
      return local(kStandardChart, in_nav(x), in_nav(test::moved(kStandardChart, x, e)));
    };
    const MatrixXd J = test::numeric_derivative(coordinates, VectorXd::Zero(x.size()));
    const MatrixXd expected = J * filter.covariance() * J.transpose();
    EXPECT_LT(test::covariance_difference(motion.covariance, expected), 1e-9);
  }
}

}  // namespace
}  // namespace chasles
