#include <cmath>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>
#include <chasles/imu/imu_buffer.hpp>

// Extrinsics and time offset as part of the state.

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class CalibrationTest : public test::OverCharts {
 protected:
  Ekf filter(test::Random& random) const {
    return test::inertial_filter(chart(), random, true, true);
  }
};
INSTANTIATE_TEST_SUITE_P(Charts, CalibrationTest, testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST_P(CalibrationTest, ErrorsAreThoseThatAreDocumented) {
  test::Random random(1);
  const State x = filter(random).state();
  ASSERT_EQ(x.calibration_size(), 19);
  ASSERT_EQ(x.core_size(), x.calibration_row() + 19);
  const VectorXd xi = 0.1 * random.normal_vector(x.size());
  const State y = test::moved(chart(), x, xi);
  EXPECT_TRUE(test::agree(local(chart(), x, y), xi, 1e-12));
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int row = *x.camera_row(i);
    const Eigen::Matrix3d R = so3::exp(xi.segment<3>(row)) * x.imu_T_camera[k].R;
    EXPECT_TRUE(test::agree(y.imu_T_camera[k].R, R, 1e-14));
    EXPECT_TRUE(
        test::agree(y.imu_T_camera[k].p, x.imu_T_camera[k].p + xi.segment<3>(row + 3), 1e-14));
  }
  EXPECT_DOUBLE_EQ(*y.time_offset, *x.time_offset + xi[x.time_offset_row()]);
  EXPECT_FALSE(x.camera_row(3));
  // An anchored landmark uses the extrinsics of its camera.
  int anchored = 0;
  for (const Landmark& landmark : y.landmarks) {
    if (!landmark.anchor) continue;
    const SE3 imu_T_camera = y.imu_T_camera[static_cast<std::size_t>(landmark.camera)];
    EXPECT_LT(test::distance(landmark.cam_T_imu * imu_T_camera, SE3{}), 1e-12);
    ++anchored;
  }
  EXPECT_EQ(anchored, 3);
}

TEST_P(CalibrationTest, AnAnchoredLandmarksPositionDependsOnItsCamera) {
  test::Random random(2);
  for (int i = 1; i < 6; i += 2) {
    Ekf ekf = filter(random);
    const State x = ekf.state();
    const MatrixXd P = ekf.covariance();
    const auto position = [&](const VectorXd& e) -> VectorXd {
      const State y = test::moved(kStandardChart, x, e);
      return y.p_world(y.landmarks[static_cast<std::size_t>(i)]);
    };
    const MatrixXd D = test::numeric_derivative(position, VectorXd::Zero(x.size()), 1e-4);
    const int row = x.landmarks[static_cast<std::size_t>(i)].row;
    MatrixXd J = MatrixXd::Identity(x.size(), x.size());
    J.middleRows<3>(row) = D;
    Ekf retired = ekf;
    ekf.make_cartesian(i);
    EXPECT_LT(test::covariance_difference(ekf.covariance(), J * P * J.transpose()), 1e-7);
    // As for a landmark that leaves the state.
    const int gone[] = {i};
    retired.retire(gone);
    EXPECT_TRUE(
        test::agree(retired.past().map().front().covariance, D * P * D.transpose(), 1e-7, 0));
  }
}

TEST_P(CalibrationTest, AnUpdateIsTheTextbooks) {
  test::Random random(3);
  Ekf ekf = filter(random);
  const State before = ekf.state();
  const MatrixXd P = ekf.covariance();
  const auto measured = test::pixel_measurements(before, random);
  const auto z = test::dense_measurement(before, measured);
  const MatrixXd K = P * z.H.transpose() * (z.H * P * z.H.transpose() + z.R).inverse();
  const auto report = ekf.update(measured);
  ASSERT_FALSE(report.failed);
  const VectorXd delta = K * z.r;
  const State& x = ekf.state();
  const int row = before.calibration_row();
  const VectorXd moved = local(kStandardChart, before, x).segment(row, 19);
  EXPECT_TRUE(test::agree(moved, delta.segment(row, 19), 1e-8));
  EXPECT_GT(delta.segment(row, 18).cwiseAbs().minCoeff(), 1e-6);
  const auto calibration = calibration_of(ekf);
  ASSERT_TRUE(calibration);
  EXPECT_EQ(calibration->imu_T_camera.size(), 3U);
  const MatrixXd expected = (P - K * z.H * P).block(row, row, 19, 19);
  EXPECT_LT(test::covariance_difference(calibration->covariance, expected), 1e-7);
}

TEST_P(CalibrationTest, CompositionLeavesItAndWhatIsPredicted) {
  test::Random random(4);
  Ekf ekf = filter(random);
  const auto calibration = *calibration_of(ekf);
  const auto squares = [&] {
    test::Random same(5);
    std::vector<double> result;
    for (const Measurement& z : test::pixel_measurements(ekf.state(), same)) {
      result.push_back(ekf.normalised_square(z));
    }
    return result;
  };
  const auto before = squares();
  ekf.compose();
  const auto after = squares();
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(after[i], before[i], 1e-8 * (1 + before[i]));
  }
  const auto same = *calibration_of(ekf);
  EXPECT_TRUE(test::agree(same.covariance, calibration.covariance, 1e-12, 0));
  EXPECT_EQ(same.time_offset, calibration.time_offset);
}

TEST(Calibration, OfAFilterWithoutAnyThereIsNone) {
  test::Random random(6);
  EXPECT_FALSE(calibration_of(test::inertial_filter(kStandardChart, random)));
  State x = test::random_state(random, {.velocity = true, .additive = 6});
  x.time_offset = 0.01;
  EXPECT_THROW(Ekf(kStandardChart, x, MatrixXd::Identity(16, 16), {.map = Ekf::Map::kHistory}),
               UsageError);
}

// Hand-held motion: smooth samples at a high rate.
ImuBuffer shaken() {
  ImuBuffer buffer({});
  for (int k = 0; k <= 4000; ++k) {
    const double t = 1e-4 * k;
    buffer.add({.time = from_seconds(t),
                .specific_force_imu = {3 * std::sin(20 * t), 2 * std::cos(17 * t), 9.8 + t},
                .angular_rate_imu = {std::cos(15 * t), 2 * std::sin(10 * t), 1 - 3 * t}});
  }
  return buffer;
}

TEST(TimeOffset, ItsColumnIsTheDerivativeByAShiftOfTheSamples) {
  test::Random random(7);
  ImuBuffer buffer = shaken();
  const InertialModel model = test::inertial_model_askew();
  for (const bool nav : {false, true}) {
    State x = test::random_state(random, {.velocity = true, .additive = 6, .nav = nav});
    x.additive *= 0.1;
    x.time_offset = 0;
    constexpr double kFrom = 0.1, kTo = 0.3;
    const auto ahead = [&](double shift) {
      return predict(model, x,
                     buffer.between(from_seconds(kFrom + shift), from_seconds(kTo + shift)));
    };
    const auto error = [&](double shift) -> VectorXd {
      const State y = test::predicted(x, ahead(shift));
      return local(kStandardChart, test::predicted(x, ahead(0)), y).head<9>();
    };
    constexpr double kShift = 0.01;
    const VectorXd numeric =
        (8 * (error(kShift) - error(-kShift)) - (error(2 * kShift) - error(-2 * kShift))) /
        (12 * kShift);
    Prediction next = ahead(0);
    const auto rate = [&](const SE3& pose, const Vector3d& v, double t) {
      const InertialState state{.world_T_imu = pose,
                                .v_world = v,
                                .accelerometer_bias = x.additive.head<3>(),
                                .gyroscope_bias = x.additive.tail<3>()};
      return motion_rate(state, gravity_world(model, x), *buffer.at(from_seconds(t)));
    };
    shift_with_time_offset(x, rate(x.world_T_imu, *x.v_world, kFrom),
                           rate(next.world_T_imu, *next.v_world, kTo), next);
    const VectorXd column = next.F.col(x.time_offset_row()).head<9>();
    EXPECT_TRUE(test::agree(column, numeric, 1e-4));
    EXPECT_GT(column.head<3>().norm(), 0.1);
    EXPECT_EQ(next.F(x.time_offset_row(), x.time_offset_row()), 1);
  }
}

// The state refers to the instant of the image; the IMU's clock shows its estimate.
TEST(TimeOffset, ByTheClockItsErrorIsAnErrorOfTheMotion) {
  test::Random random(8);
  const Ekf ekf = test::inertial_filter(kStandardChart, random, false, true);
  const State& x = ekf.state();
  const Vector9d rate = random.normal_vector(9);
  NavScratch scratch;
  const NavState by_clock = nav_state_by_clock(ekf, rate, scratch);
  const MatrixXd P = ekf.core_covariance();
  MatrixXd J = MatrixXd::Identity(x.core_size(), x.core_size());
  J.block<9, 1>(0, x.time_offset_row()) = -rate;
  const MatrixXd expected = (J * P * J.transpose()).topLeftCorner<15, 15>();
  EXPECT_TRUE(test::agree(by_clock.covariance, expected, 1e-10, 0));
  EXPECT_TRUE(test::agree(nav_state(ekf).covariance, P.topLeftCorner<15, 15>(), 1e-12, 0));
}

}  // namespace
}  // namespace chasles
