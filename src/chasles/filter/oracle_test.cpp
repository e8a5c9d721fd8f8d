#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/oracle_numbers_testing.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/filter/textbook_motion_testing.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {

namespace test {
// GoogleTest's output for a case.
void PrintTo(const OracleCase& oracle, std::ostream* out) { *out << oracle.chart; }
}  // namespace test

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Comparison with an independent implementation in numpy (oracle_numbers_testing.hpp).
constexpr double kTolerance = 1e-9;

template <int kRows, int kCols, std::size_t kSize>
Eigen::Matrix<double, kRows, kCols> matrix(const std::array<double, kSize>& numbers, int at = 0) {
  static_assert(static_cast<std::size_t>(kRows * kCols) <= kSize);
  Eigen::Matrix<double, kRows, kCols> result;
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j < kCols; ++j) {
      result(i, j) = numbers[static_cast<std::size_t>(at + i * kCols + j)];
    }
  }
  return result;
}

State state_of(const std::array<double, 27>& numbers) {
  State x;
  x.world_T_imu = {matrix<3, 3>(numbers), matrix<3, 1>(numbers, 9)};
  x.v_world = matrix<3, 1>(numbers, 12);
  x.additive = matrix<6, 1>(numbers, 15);
  for (int i = 0; i < 2; ++i) {
    x.landmarks.push_back({.id = i,
                           .p_world = matrix<3, 1>(numbers, 21 + 3 * i),
                           .row = 15 + 3 * i,
                           .observations = 1});
  }
  return x;
}

StereoRig rig_of(const test::OracleCase& oracle) {
  const auto& c = oracle.camera;
  const SE3 imu_T_cam0{matrix<3, 3>(c, 5), matrix<3, 1>(c, 14)};
  return {.fx = c[0],
          .fy = c[1],
          .cx = c[2],
          .cy = c[3],
          .baseline = c[4],
          .cam0_T_imu = imu_T_cam0.inverse()};
}

MatrixXd change_of_chart(const ErrorChart& chart, const State& x) {
  MatrixXd T = MatrixXd::Identity(21, 21);
  push(chart, x, T);
  return T;
}

class OracleTest : public ::testing::TestWithParam<test::OracleCase> {
 protected:
  const test::OracleCase& oracle() const { return GetParam(); }
  const ErrorChart& chart() const { return error_chart(oracle().chart); }
  State state() const { return state_of(oracle().state); }
};

INSTANTIATE_TEST_SUITE_P(Charts, OracleTest, ::testing::ValuesIn(test::kOracleCases),
                         [](const auto& of) {
                           return test::chart_test_name({&error_chart(of.param.chart), of.index});
                         });

TEST_P(OracleTest, ErrorMovesTheStateToTheSamePlace) {
  const State moved = test::moved(chart(), state(), matrix<21, 1>(oracle().error));
  EXPECT_LT(test::distance(moved, state_of(oracle().retracted)), kTolerance);
}

TEST_P(OracleTest, ChangeOfChartIsTheSameMatrix) {
  MatrixXd expected = MatrixXd::Identity(21, 21);
  expected.topLeftCorner<9, 9>() = matrix<9, 9>(oracle().change);
  expected.bottomLeftCorner<6, 3>() = matrix<6, 3>(oracle().change_landmarks);
  EXPECT_TRUE(test::agree(change_of_chart(chart(), state()), expected, kTolerance));
}

TEST_P(OracleTest, InertialTransitionSeenInTheChartIsTheSameMatrix) {
  test::Inertial model;
  model.g_world = matrix<3, 1>(oracle().sample, 6);
  const test::InertialSample sample{.f_imu = matrix<3, 1>(oracle().sample),
                                    .w_imu = matrix<3, 1>(oracle().sample, 3)};
  const State next = model.step(state(), sample, oracle().tau);
  EXPECT_LT(test::distance(next, state_of(oracle().next)), kTolerance);
  MatrixXd F = MatrixXd::Identity(21, 21);
  F.topLeftCorner<15, 15>() = model.predict(state(), sample, oracle().tau).F;
  MatrixXd expected = MatrixXd::Identity(21, 21);
  expected.topLeftCorner<15, 15>() = matrix<15, 15>(oracle().transition);
  expected.bottomLeftCorner<6, 15>() = matrix<6, 15>(oracle().transition_landmarks);
  EXPECT_TRUE(test::agree(in_chart(chart(), F, state(), next), expected, kTolerance));
}

TEST_P(OracleTest, PixelsHaveTheSameDerivative) {
  const MatrixXd T = change_of_chart(chart(), state());
  for (int i = 0; i < 2; ++i) {
    // With an observation at the image's origin, the residual is minus the projection.
    const auto z = measure_stereo(rig_of(oracle()), StereoRows::kAll, {}, state(), i, {});
    ASSERT_TRUE(z);
    EXPECT_TRUE(
        test::agree(-z->residual.head<2>(), (matrix<2, 1>(oracle().pixels, 2 * i)), kTolerance));
    const auto in_chart = matrix<2, 9>(oracle().d_pixels, 18 * i);
    MatrixXd expected = MatrixXd::Zero(2, 21);
    expected.leftCols<6>() = in_chart.leftCols<6>();
    expected.middleCols<3>(15 + 3 * i) = in_chart.rightCols<3>();
    MatrixXd H = MatrixXd::Zero(2, 21);
    H.leftCols<6>() = z->d_core.topRows<2>();
    H.middleCols<3>(15 + 3 * i) = z->d_landmark.topRows<2>();
    EXPECT_TRUE(test::agree(H, expected * T, kTolerance));
  }
}

TEST_P(OracleTest, StereoPairBeginsTheSameLandmark) {
  const auto seen = matrix<3, 1>(oracle().seen);
  const StereoObservation observation{.landmark = 1,
                                      .pixels = {seen[0], seen[1], seen[2], seen[1]}};
  // uL and uR independent, of 1 px each: so are their mean and their difference.
  const StereoNoise noise{.u = std::sqrt(0.5), .v = 1, .disparity = std::sqrt(2.0)};
  const auto initialised = initialise_landmark(rig_of(oracle()), noise, state(), observation);
  ASSERT_TRUE(initialised);
  EXPECT_TRUE(test::agree(initialised->p_world, (matrix<3, 1>(oracle().initialised)), kTolerance));
  EXPECT_TRUE(
      test::agree(initialised->noise, (matrix<3, 3>(oracle().initialised_noise)), kTolerance));
  MatrixXd in_chart = initialised->d_pose;
  if (chart().landmark_block) {
    in_chart.leftCols<3>() += chart().landmark_block(initialised->p_world);
  }
  const MatrixXd T = change_of_chart(chart(), state()).topLeftCorner<6, 6>();
  EXPECT_TRUE(test::agree(in_chart, matrix<3, 6>(oracle().d_initialised) * T, kTolerance));
}

}  // namespace
}  // namespace chasles
