#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/inertial_testing.hpp>

// Ekf::compose, against the definition of the composition step (docs/derivations.md, D51).

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

using EkfCompositionTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, EkfCompositionTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

// The same state in the frame of its own IMU.
State composed(State x) {
  const SE3 imu_T_world = x.world_T_imu.inverse();
  x.nav_T_world = *x.nav_T_world * x.world_T_imu;
  *x.v_world = imu_T_world.R * *x.v_world;
  for (Landmark& landmark : x.landmarks) {
    if (!landmark.anchor) landmark.p_world = imu_T_world * landmark.p_world;
  }
  for (Clone& clone : x.clones) clone.world_T_imu = imu_T_world * clone.world_T_imu;
  x.world_T_imu = {};
  return x;
}

TEST_P(EkfCompositionTest, IsTheChangeOfFrameAndItsDerivative) {
  test::Random random(1);
  Ekf filter = test::inertial_filter(chart(), random);
  const State before = filter.state();
  const MatrixXd P = filter.covariance();
  filter.compose();
  EXPECT_LT(test::distance(filter.state(), composed(before)), 1e-12);
  const auto coordinates = [&](const VectorXd& e) {
    return local(kStandardChart, composed(before),
                 composed(test::moved(kStandardChart, before, e)));
  };
  const MatrixXd J = test::numeric_derivative(coordinates, VectorXd::Zero(before.size()));
  const MatrixXd after = filter.covariance();
  EXPECT_TRUE(after.topRows<6>().isZero(0));
  EXPECT_TRUE(after.leftCols<6>().isZero(0));
  EXPECT_LT(test::covariance_difference(after, J * P * J.transpose()), 1e-9);
  EXPECT_EQ(after, after.transpose());
}

TEST_P(EkfCompositionTest, NoMeasurementSeesIt) {
  test::Random random(2);
  Ekf filter = test::inertial_filter(chart(), random);
  const auto measured = [&] {
    std::vector<Measurement> result;
    for (const Camera& camera : test::inertial_cameras()) {
      for (int i = 0; i < 6; ++i) {
        result.push_back(*measure_pixel(camera, 1, filter.state(), i, {100, 200}));
      }
    }
    return result;
  };
  const std::vector<Measurement> before = measured();
  const auto z = test::dense_measurement(filter.state(), before);
  const MatrixXd S = z.H * filter.covariance() * z.H.transpose();
  const double square = filter.joint_normalised_square(before);
  filter.compose();
  const std::vector<Measurement> after = measured();
  const auto z_after = test::dense_measurement(filter.state(), after);
  EXPECT_LT((z_after.r - z.r).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT((z_after.H - z.H).cwiseAbs().maxCoeff(), 1);
  EXPECT_TRUE(test::agree(z_after.H * filter.covariance() * z_after.H.transpose(), S, 1e-12, 0));
  EXPECT_NEAR(filter.joint_normalised_square(after), square, 1e-8 * square);
}

TEST_P(EkfCompositionTest, MotionInNavStaysWithItsCovariance) {
  test::Random random(3);
  Ekf filter = test::inertial_filter(chart(), random);
  const NavState before = nav_state(filter);
  filter.compose();
  const NavState after = nav_state(filter);
  EXPECT_LT(test::distance(after.nav_T_imu, before.nav_T_imu), 1e-12);
  EXPECT_LT((after.v_nav - before.v_nav).norm(), 1e-12);
  EXPECT_LT(test::covariance_difference(after.covariance, before.covariance), 1e-11);
}

// J(x+) Phi(x) = J(x'+) Phi(x') J(x).
TEST_P(EkfCompositionTest, CommutesWithPropagation) {
  test::Random random(4);
  const InertialModel model = test::inertial_model_askew();
  const std::vector<ImuInterval> intervals = test::imu_intervals(random, 4);
  Ekf late = test::inertial_filter(chart(), random);
  Ekf early = late;
  early.compose();
  for (Ekf* filter : {&late, &early}) {
    filter->propagate(predict(model, filter->state(), intervals));
  }
  EXPECT_LT(test::distance(nav_state(early).nav_T_imu, nav_state(late).nav_T_imu), 1e-11);
  EXPECT_LT(test::covariance_difference(nav_state(early).covariance, nav_state(late).covariance),
            1e-11);
  for (Ekf* filter : {&late, &early}) filter->compose();
  EXPECT_LT(test::distance(early.state(), late.state()), 1e-11);
  EXPECT_LT(test::covariance_difference(early.covariance(), late.covariance()), 1e-10);
}

// The update of a composed filter equals that of one without composition, whether or not the chart
// rotates with the pose. This holds to first order only, hence the small correction.
TEST_P(EkfCompositionTest, CorrectionIsTheSameToFirstOrder) {
  test::Random random(5);
  Ekf late = test::inertial_filter(chart(), random);
  Ekf early = late;
  early.compose();
  for (Ekf* filter : {&late, &early}) {
    test::Random same(55);
    std::vector<Measurement> measurements = test::pixel_measurements(filter->state(), same);
    for (Measurement& z : measurements) z.residual *= 1e-5;
    filter->update(measurements);
    filter->compose();
  }
  EXPECT_LT(test::distance(early.state(), late.state()), 1e-9);
}

TEST(EkfComposition, NeedsNavInTheState) {
  test::Random random(6);
  Ekf filter = test::inertial_filter(kStandardChart, random, false);
  EXPECT_THROW(filter.compose(), UsageError);
}

}  // namespace
}  // namespace chasles
