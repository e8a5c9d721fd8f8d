#include <chasles/filter/inertial_oracle_numbers_testing.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {

namespace test {
// GoogleTest's output for a case.
void PrintTo(const InertialOracleCase& oracle, std::ostream* out) { *out << oracle.chart; }
}  // namespace test

namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Comparison with an independent implementation in numpy (inertial_oracle_numbers_testing.hpp).
constexpr double kInertialTolerance = 1e-9;
constexpr int kErrors = 27;
constexpr int kCore = 21;

template <int kR, int kC, std::size_t kSize>
Eigen::Matrix<double, kR, kC> inertial_matrix(const std::array<double, kSize>& numbers,
                                              int at = 0) {
  static_assert(static_cast<std::size_t>(kR * kC) <= kSize);
  Eigen::Matrix<double, kR, kC> result;
  for (int i = 0; i < kR; ++i) {
    for (int j = 0; j < kC; ++j) result(i, j) = numbers[static_cast<std::size_t>(at + i * kC + j)];
  }
  return result;
}

State state_of(const std::array<double, 39>& numbers) {
  State x;
  x.world_T_imu = {inertial_matrix<3, 3>(numbers), inertial_matrix<3, 1>(numbers, 9)};
  x.v_world = inertial_matrix<3, 1>(numbers, 12);
  x.nav_T_world = SE3{inertial_matrix<3, 3>(numbers, 15), inertial_matrix<3, 1>(numbers, 24)};
  x.additive = inertial_matrix<6, 1>(numbers, 27);
  for (int i = 0; i < 2; ++i) {
    x.landmarks.push_back({.id = i, .p_world = inertial_matrix<3, 1>(numbers, 33 + 3 * i)});
    x.landmarks.back().row = kCore + 3 * i;
  }
  return x;
}

class InertialOracleTest : public ::testing::TestWithParam<test::InertialOracleCase> {
 protected:
  const test::InertialOracleCase& oracle() const { return GetParam(); }
  const ErrorChart& chart() const { return error_chart(oracle().chart); }
  State state() const { return state_of(oracle().state); }
  Camera camera() const {
    const auto& c = oracle().camera;
    const SE3 imu_T_cam{inertial_matrix<3, 3>(c, 4), inertial_matrix<3, 1>(c, 13)};
    return {.width = 700,
            .height = 540,
            .fx = c[0],
            .fy = c[1],
            .cx = c[2],
            .cy = c[3],
            .cam_T_imu = imu_T_cam.inverse()};
  }
};

INSTANTIATE_TEST_SUITE_P(Charts, InertialOracleTest,
                         ::testing::ValuesIn(test::kInertialOracleCases), [](const auto& of) {
                           return test::chart_test_name({&error_chart(of.param.chart), of.index});
                         });

TEST_P(InertialOracleTest, ErrorMovesTheStateToTheSamePlace) {
  const State moved = test::moved(chart(), state(), inertial_matrix<kErrors, 1>(oracle().error));
  EXPECT_LT(test::distance(moved, state_of(oracle().retracted)), kInertialTolerance);
}

// The numpy model is continuous in time: the comparison uses the limit of short times.
TEST_P(InertialOracleTest, DynamicsAreTheSameMatrices) {
  InertialModel model;
  model.gravity_nav = inertial_matrix<3, 1>(oracle().sample, 6);
  model.noise.accelerometer_noise_density = 1.5;
  model.noise.gyroscope_noise_density = 0.5;
  const State x = state();
  MatrixXd F, Q;
  const auto at = [&](double tau, double weight) {
    const ImuInterval u{.tau = tau,
                        .specific_force_imu = inertial_matrix<3, 1>(oracle().sample),
                        .angular_rate_imu = inertial_matrix<3, 1>(oracle().sample, 3)};
    const Prediction to = predict(model, x, {&u, 1});
    const State next = test::predicted(x, to);
    const MatrixXd T = test::change_of_chart(chart(), next).leftCols(kCore);
    F += weight / tau *
         (in_chart(chart(), test::with_the_others(to.F, x), x, next) -
          MatrixXd::Identity(kErrors, kErrors));
    Q += weight / tau * T * to.Q * T.transpose();
  };
  F = Q = MatrixXd::Zero(kErrors, kErrors);
  constexpr double kTau = 1e-3;  // the weights cancel the first three powers of tau
  at(kTau, -1. / 21);
  at(kTau / 2, 14. / 21);
  at(kTau / 4, -56. / 21);
  at(kTau / 8, 64. / 21);
  EXPECT_TRUE(test::agree(F, (inertial_matrix<kErrors, kErrors>(oracle().F)), kInertialTolerance));
  const MatrixXd G = inertial_matrix<kErrors, 6>(oracle().G);
  Eigen::VectorXd density(6);
  density << Vector3d::Constant(1.5), Vector3d::Constant(0.5);
  EXPECT_TRUE(
      test::agree(Q, G * density.cwiseAbs2().asDiagonal() * G.transpose(), kInertialTolerance));
}

TEST_P(InertialOracleTest, PixelsHaveTheSameDerivative) {
  const State x = state();
  const MatrixXd T = test::change_of_chart(chart(), x);
  for (int i = 0; i < 2; ++i) {
    // With an observation at the image's origin, the residual is minus the projection.
    const auto z = measure_pixel(camera(), 1, x, i, Vector2d::Zero());
    ASSERT_TRUE(z);
    EXPECT_TRUE(test::agree(-z->residual, (inertial_matrix<2, 1>(oracle().pixels, 2 * i)),
                            kInertialTolerance));
    const auto theirs = inertial_matrix<2, 9>(oracle().d_pixels, 18 * i);
    MatrixXd expected = MatrixXd::Zero(2, kErrors);
    expected.leftCols<6>() = theirs.leftCols<6>();
    expected.middleCols<3>(kCore + 3 * i) = theirs.rightCols<3>();
    EXPECT_TRUE(test::agree(test::dense_measurement(x, {*z}).H, expected * T, kInertialTolerance));
  }
}

TEST_P(InertialOracleTest, PixelBeginsTheSameLandmark) {
  const auto seen = inertial_matrix<5, 1>(oracle().mono);
  const auto initialised =
      initialise_at_depth(camera(), seen[3], state(), 1, seen.head<2>(), seen[2], seen[4]);
  ASSERT_TRUE(initialised);
  EXPECT_TRUE(test::agree(initialised->p_world, (inertial_matrix<3, 1>(oracle().initialised)),
                          kInertialTolerance));
  EXPECT_TRUE(test::agree(initialised->noise, (inertial_matrix<3, 3>(oracle().initialised_noise)),
                          kInertialTolerance));
  MatrixXd in_chart = initialised->d_pose;
  if (chart().landmark_block)
    in_chart.leftCols<3>() += chart().landmark_block(initialised->p_world);
  const MatrixXd T = pose_block(chart(), state().world_T_imu);
  EXPECT_TRUE(
      test::agree(in_chart, inertial_matrix<3, 6>(oracle().d_initialised) * T, kInertialTolerance));
}

TEST_P(InertialOracleTest, AnchoredPixelHasTheSameDerivative) {
  State x = state();
  x.landmarks = {{.id = 3, .row = kCore + 6, .anchor = 5}};
  x.landmarks[0].cam_T_imu = camera().cam_T_imu;
  x.landmarks[0].inverse_depth = inertial_matrix<3, 1>(oracle().inverse_depth);
  const SE3 anchor{inertial_matrix<3, 3>(oracle().anchor),
                   inertial_matrix<3, 1>(oracle().anchor, 9)};
  x.clones = {{.id = 5, .time = {}, .world_T_imu = anchor, .row = kCore}};
  const auto z = measure_pixel(camera(), 1, x, 0, Vector2d::Zero());
  ASSERT_TRUE(z);
  EXPECT_TRUE(test::agree(-z->residual, (inertial_matrix<2, 1>(oracle().anchored_pixel)),
                          kInertialTolerance));
  const auto theirs = inertial_matrix<2, 15>(oracle().d_anchored_pixel);
  MatrixXd expected = MatrixXd::Zero(2, x.size());
  expected.leftCols<6>() = theirs.leftCols<6>();
  expected.rightCols<9>() = theirs.rightCols<9>();
  const MatrixXd T = test::change_of_chart(chart(), x);
  EXPECT_TRUE(test::agree(test::dense_measurement(x, {*z}).H, expected * T, kInertialTolerance));
}

TEST_P(InertialOracleTest, CompositionIsTheSameMatrix) {
  test::Random random(1);
  const State x = state();
  Ekf filter(chart(), x, test::random_covariance(random, kErrors, 0.1), {.map = Ekf::Map::kFrozen});
  const MatrixXd T = test::change_of_chart(chart(), x);
  const MatrixXd P = T * filter.covariance() * T.transpose();
  filter.compose();
  EXPECT_LT(test::distance(filter.state(), state_of(oracle().composed)), kInertialTolerance);
  const MatrixXd T_after = test::change_of_chart(chart(), filter.state());
  const MatrixXd after = T_after * filter.covariance() * T_after.transpose();
  const MatrixXd J = inertial_matrix<kErrors, kErrors>(oracle().J_compose);
  EXPECT_TRUE(test::agree(after, J * P * J.transpose(), kInertialTolerance));
}

}  // namespace
}  // namespace chasles
