#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <chasles/filter/inertial_testing.hpp>

// Scales, misalignments and g-sensitivity of the IMU as random constants of the state.

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

using ImuParametersTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, ImuParametersTest, testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

ImuCorrection some_errors(test::Random& random, ImuCorrection groups = {}) {
  groups.add(0.05 * random.normal_vector(groups.size()));
  return groups;
}

// With everything that the core can have.
State full_state(test::Random& random, bool nav, const ImuCorrection& groups = {}) {
  State x = test::random_state(
      random,
      {.velocity = true, .additive = 6, .landmarks = 2, .nav = nav, .clones = 1, .anchored = true});
  const Camera camera = test::euroc_camera();
  x.imu_T_camera = {camera.cam_T_imu.inverse()};
  x.time_offset = 0.01;
  x.intrinsics = {intrinsics_of(camera)};
  x.imu = some_errors(random, groups);
  int row = x.core_size();
  x.clones[0].row = row;
  for (Landmark& landmark : x.landmarks) landmark.row = row + 6 + 3 * static_cast<int>(landmark.id);
  return x;
}

std::vector<ImuCorrection> groups() {
  return {{},
          {.has_misalignment = false, .has_g_sensitivity = false},
          {.has_scale = false},
          {.has_scale = false, .has_misalignment = false}};
}

// A core without cameras, in the standard chart.
Ekf plain_filter(test::Random& random, std::vector<int> considered = {}) {
  State x = test::random_state(random, {.velocity = true, .additive = 6});
  x.additive *= 0.1;
  x.time_offset = 0.01;
  x.imu = some_errors(random);
  return {kStandardChart,
          x,
          test::random_covariance(random, x.core_size(), 0.02),
          {.map = Ekf::Map::kFrozen, .considered = std::move(considered)}};
}

TEST_P(ImuParametersTest, ErrorsMoveTheStateAndBack) {
  test::Random random(1);
  for (const ImuCorrection& some : groups()) {
    const State x = full_state(random, true, some);
    EXPECT_EQ(x.imu_row() + some.size(), x.core_size());
    VectorXd xi = VectorXd::Zero(x.size());
    xi.segment(x.imu_row(), some.size()) = 0.1 * random.normal_vector(some.size());
    const State y = test::moved(chart(), x, xi);
    EXPECT_TRUE(test::agree(local(chart(), x, y), xi, 1e-12));
    const VectorXd moved = y.imu->parameters() - x.imu->parameters();
    EXPECT_TRUE(test::agree(moved, xi.segment(x.imu_row(), some.size()), 1e-14));
  }
}

TEST_P(ImuParametersTest, TransitionIsTheDerivativeOfTheMean) {
  test::Random random(2);
  const InertialModel model = test::inertial_model_askew();
  for (const ImuCorrection& some : groups()) {
    for (const bool nav : {false, true}) {
      const State x = full_state(random, nav, some);
      const std::vector<ImuInterval> intervals = test::imu_intervals(random, 5);
      const auto after = [&](const State& from) {
        return test::predicted(from, predict(model, from, intervals));
      };
      const State next = after(x);
      const int row = x.imu_row(), n = some.size();
      const auto mapped = [&](const VectorXd& errors) -> VectorXd {
        VectorXd xi = VectorXd::Zero(x.size());
        xi.segment(row, n) = errors;
        return local(chart(), next, after(test::moved(chart(), x, xi)));
      };
      const MatrixXd F = test::with_the_others(predict(model, x, intervals).F, x);
      const MatrixXd columns = in_chart(chart(), F, x, next).middleCols(row, n);
      EXPECT_TRUE(
          test::agree(columns, test::numeric_derivative(mapped, VectorXd::Zero(n), 1e-3), 1e-8));
      EXPECT_TRUE(F.block(row, row, n, n).isIdentity(0));
    }
  }
}

// The biases' columns and the noise are those of the corrected samples.
TEST(ImuParameters, AllElseIsThePredictionByCorrectedSamples) {
  test::Random random(3);
  const InertialModel model = test::inertial_model_askew();
  const State x = full_state(random, true);
  std::vector<ImuInterval> intervals = test::imu_intervals(random, 5);
  const Prediction with = predict(model, x, intervals);
  State without = x;
  without.imu.reset();
  for (ImuInterval& interval : intervals) interval = corrected(*x.imu, interval);
  const Prediction expected = predict(model, without, intervals);
  const int n = without.core_size();
  EXPECT_EQ(with.world_T_imu.p, expected.world_T_imu.p);
  EXPECT_EQ(*with.v_world, *expected.v_world);
  EXPECT_EQ(with.F.topLeftCorner(n, n), expected.F);
  EXPECT_EQ(with.Q.topLeftCorner(n, n), expected.Q);
  EXPECT_TRUE(with.Q.bottomRows(x.imu->size()).isZero(0));
}

// A push along x and a turn about z, as they are on paper.
TEST(ImuParameters, AScaleIsAnErrorOfWayAndAngle) {
  constexpr double kForce = 2, kRate = 0.5, kSeconds = 3;
  State x;
  x.v_world = Vector3d::Zero();
  x.additive = VectorXd::Zero(6);
  x.imu = ImuCorrection{};
  const InertialModel model{.gravity_nav = Vector3d::Zero(), .noise = {}};
  const auto column = [&](const ImuInterval& sample, const std::string& name) -> VectorXd {
    const std::vector<ImuInterval> intervals(30, sample);
    const auto names = x.imu->names();
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    return predict(model, x, intervals).F.col(x.imu_row() + static_cast<int>(at)).head<9>();
  };
  const double tau = kSeconds / 30;
  const ImuInterval push{.tau = tau, .specific_force_imu = {kForce, 0, 0}};
  const ImuInterval turn{.tau = tau, .angular_rate_imu = {0, 0, kRate}};
  VectorXd expected = VectorXd::Zero(9);
  expected[3] = kForce * kSeconds * kSeconds / 2;
  expected[6] = kForce * kSeconds;
  EXPECT_TRUE(test::agree(column(push, "accelerometer_scale_x"), expected, 1e-12));
  expected = VectorXd::Zero(9);
  expected[4] = kForce * kSeconds * kSeconds / 2;
  expected[7] = kForce * kSeconds;
  EXPECT_TRUE(test::agree(column(push, "accelerometer_misalignment_y_x"), expected, 1e-12));
  expected = VectorXd::Zero(9);
  expected[2] = kRate * kSeconds;
  EXPECT_TRUE(test::agree(column(turn, "gyroscope_scale_z"), expected, 1e-12));
  expected = VectorXd::Zero(9);  // turns the push, about z
  expected[2] = -kForce * kSeconds;
  expected[4] = -kForce * kForce * std::pow(kSeconds, 3) / 6;
  expected[7] = -kForce * kForce * kSeconds * kSeconds / 2;
  EXPECT_TRUE(test::agree(column(push, "g_sensitivity_z_x"), expected, 1e-12));
}

// To first order in the time, the columns in the chart are those of the biases with the other sign,
// times the sample's derivative.
TEST_P(ImuParametersTest, FirstOrderTransitionHasThemToFirstOrder) {
  if (chart().name == kRightSen3Chart.name) return;
  test::Random random(4);
  InertialModel exact = test::inertial_model_askew(), first = exact;
  first.first_order = &chart();
  const State x = full_state(random, false);
  const ImuInterval sample = test::imu_intervals(random, 1).front();
  const auto difference = [&](double tau) {
    ImuInterval interval = sample;
    interval.tau = tau;
    const auto columns = [&](const InertialModel& model) -> MatrixXd {
      return predict(model, x, {&interval, 1}).F.block(0, x.imu_row(), 9, x.imu->size());
    };
    return (columns(first) - columns(exact)).norm() / columns(exact).norm();
  };
  EXPECT_LT(difference(1e-3), 0.02);
  EXPECT_NEAR(difference(1e-3) / difference(5e-4), 2, 0.4);
}

TEST_P(ImuParametersTest, CompositionLeavesThem) {
  test::Random random(5);
  const State x = full_state(random, true);
  State core = x;
  core.landmarks.clear();
  core.clones.clear();
  Ekf filter(chart(), core, test::random_covariance(random, core.core_size(), 0.05),
             {.map = Ekf::Map::kFrozen});
  const int row = core.imu_row(), n = core.imu->size();
  const auto nav = nav_state(filter);
  const MatrixXd before = filter.core_covariance().block(row, row, n, n);
  filter.compose();
  EXPECT_EQ(filter.state().imu->parameters(), core.imu->parameters());
  EXPECT_TRUE(
      test::agree(MatrixXd(filter.core_covariance().block(row, row, n, n)), before, 1e-12, 0));
  EXPECT_TRUE(test::agree(nav_state(filter).covariance, nav.covariance, 1e-9, 0));
}

TEST(ImuParameters, AreThoseOfTheCalibration) {
  test::Random random(6);
  const Ekf filter = plain_filter(random);
  const auto calibration = calibration_of(filter);
  ASSERT_TRUE(calibration && calibration->imu);
  EXPECT_EQ(calibration->imu->parameters(), filter.state().imu->parameters());
  EXPECT_EQ(calibration->imu_row(), 1);  // after the time offset
  EXPECT_EQ(calibration->covariance.bottomRightCorner(24, 24),
            filter.core_covariance().bottomRightCorner(24, 24));
}

// Steps and updates of a filter that considers clock and IMU are those of a dense Schmidt-Kalman
// filter: no gain for these rows, Joseph's form.
TEST(ImuParameters, AndClockAreConsideredAsBySchmidt) {
  test::Random random(7);
  const State start = plain_filter(random).state();
  std::vector<int> rows{start.time_offset_row()};
  for (int i = 0; i < start.imu->size(); ++i) rows.push_back(start.imu_row() + i);
  test::Random same(7);
  Ekf filter = plain_filter(same, rows);
  const InertialModel model = test::inertial_model_askew();
  MatrixXd P = filter.core_covariance();
  for (int k = 0; k < 5; ++k) {
    const State x = filter.state();
    Prediction next = predict(model, x, test::imu_intervals(random, 3));
    shift_with_time_offset(x, random.normal_vector(9), random.normal_vector(9), next);
    filter.propagate(next);
    P = next.F * P * next.F.transpose() + next.Q;
    Measurement z;
    z.core_column = 3;
    z.residual = 0.01 * random.normal_vector(3);
    z.d_core = Eigen::Matrix3d::Identity();
    z.noise = 0.01 * Eigen::Matrix3d::Identity();
    MatrixXd H = MatrixXd::Zero(3, P.rows());
    H.middleCols<3>(3).setIdentity();
    MatrixXd K = P * H.transpose() * (H * P * H.transpose() + z.noise).inverse();
    for (const int row : rows) K.row(row).setZero();
    const MatrixXd I_KH = MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    P = I_KH * P * I_KH.transpose() + K * z.noise * K.transpose();
    const Vector3d before = filter.state().world_T_imu.p;
    filter.update({&z, 1});
    const VectorXd delta = K * z.residual;
    EXPECT_TRUE(test::agree(Vector3d(filter.state().world_T_imu.p - before),
                            Vector3d(delta.segment<3>(3)), 1e-9));
    EXPECT_TRUE(test::agree(filter.core_covariance(), P, 1e-9, 0)) << k;
  }
  EXPECT_EQ(filter.state().time_offset, start.time_offset);
  EXPECT_EQ(filter.state().imu->parameters(), start.imu->parameters());
}

}  // namespace
}  // namespace chasles
