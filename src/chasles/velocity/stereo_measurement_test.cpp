#include <chasles/filter/testing.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr StereoRows kAllRows[] = {StereoRows::kAll, StereoRows::kMeanDisparity, StereoRows::kMean};

StereoRig rig() {
  Eigen::Matrix3d axes;  // z forward, x right, y down
  axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {.fx = 520,
          .fy = 500,
          .cx = 600,
          .cy = 180,
          .baseline = 0.5,
          .cam0_T_imu = {axes * so3::exp({0.02, -0.03, 0.04}), {0.1, 0.9, -0.3}}};
}

const StereoNoise kPixelNoise{.u = 0.6, .v = 0.7, .disparity = 0.9};

// A random pose that has one landmark in front of it, `depth` metres away.
State state_before_landmark(test::Random& random, double depth) {
  State x =
      test::random_state(random, {.velocity = false, .additive = 2, .landmarks = 1, .gap = 0});
  x.landmarks[0].p_world = x.world_T_imu * Eigen::Vector3d(depth, 0.2 * depth, -0.1 * depth);
  return x;
}

Eigen::Vector4d projected(const State& x) {
  const SE3 cam0_T_world = rig().cam0_T_imu * x.world_T_imu.inverse();
  return project(rig(), cam0_T_world * x.landmarks[0].p_world)->pixels;
}

// Pixels with these mean u, mean v and disparity.
StereoObservation observation(const Eigen::Vector3d& rows) {
  return {.landmark = 7,
          .pixels = {rows[0] + rows[2] / 2, rows[1], rows[0] - rows[2] / 2, rows[1]}};
}

TEST(StereoMeasurement, HasTheDerivativeOfItsResidual) {
  test::Random random(1);
  for (const StereoRows rows : kAllRows) {
    for (const double depth : {2.0, 10.0, 80.0}) {
      const State x = state_before_landmark(random, depth);
      const StereoObservation seen{.landmark = 0, .pixels = projected(x)};
      const auto z = measure_stereo(rig(), rows, kPixelNoise, x, 0, seen);
      ASSERT_TRUE(z);
      const auto residual = [&](const VectorXd& e) -> VectorXd {
        return measure_stereo(rig(), rows, kPixelNoise, test::moved(kStandardChart, x, e), 0, seen)
            ->residual;
      };
      MatrixXd H = MatrixXd::Zero(z->residual.size(), 11);
      H.middleCols(z->core_column, z->d_core.cols()) = z->d_core;
      H.rightCols<3>() = z->d_landmark;
      EXPECT_TRUE(
          test::agree(-H, test::numeric_derivative(residual, VectorXd::Zero(11), 1e-4), 1e-9));
    }
  }
}

TEST(StereoMeasurement, ResidualIsWhatWasSeenMinusWhatIsExpected) {
  test::Random random(2);
  const State x = state_before_landmark(random, 10);
  const StereoObservation seen{.landmark = 0, .pixels = projected(x) + Eigen::Vector4d(4, 3, 2, 1)};
  const auto residual = [&](StereoRows rows) -> VectorXd {
    return measure_stereo(rig(), rows, kPixelNoise, x, 0, seen)->residual;
  };
  EXPECT_TRUE(test::agree(residual(StereoRows::kAll), Eigen::Vector4d(4, 3, 2, 1), 1e-12));
  EXPECT_TRUE(test::agree(residual(StereoRows::kMeanDisparity), Eigen::Vector3d(3, 2, 2), 1e-12));
  EXPECT_TRUE(test::agree(residual(StereoRows::kMean), Eigen::Vector2d(3, 2), 1e-12));
}

TEST(StereoMeasurement, NoiseIsThatOfItsRows) {
  test::Random random(3);
  const State x = state_before_landmark(random, 10);
  const StereoObservation seen{.landmark = 0, .pixels = projected(x)};
  const auto noise = [&](StereoRows rows) -> MatrixXd {
    return measure_stereo(rig(), rows, kPixelNoise, x, 0, seen)->noise;
  };
  const Eigen::Vector4d all(0.36, 0.49, 0.36, 0.49);
  const Eigen::Vector3d three(0.36, 0.49, 0.81);
  EXPECT_TRUE(test::agree(noise(StereoRows::kAll), MatrixXd(all.asDiagonal()), 1e-15));
  EXPECT_TRUE(test::agree(noise(StereoRows::kMeanDisparity), MatrixXd(three.asDiagonal()), 1e-15));
  EXPECT_TRUE(test::agree(noise(StereoRows::kMean), MatrixXd(three.head<2>().asDiagonal()), 1e-15));
}

TEST(StereoMeasurement, PointBehindTheCamerasIsNotMeasured) {
  test::Random random(4);
  State x = state_before_landmark(random, 10);
  const StereoObservation seen{.landmark = 0, .pixels = projected(x)};
  x.landmarks[0].p_world = x.world_T_imu * Eigen::Vector3d(-10, 0, 0);
  EXPECT_FALSE(measure_stereo(rig(), StereoRows::kAll, kPixelNoise, x, 0, seen));
}

TEST(NewLandmark, NeedsAPositiveDisparity) {
  EXPECT_FALSE(initialise_landmark(rig(), kPixelNoise, State{}, observation({600, 180, 0})));
  EXPECT_FALSE(initialise_landmark(rig(), kPixelNoise, State{}, observation({600, 180, -3})));
  EXPECT_TRUE(initialise_landmark(rig(), kPixelNoise, State{}, observation({600, 180, 3})));
}

TEST(NewLandmark, IsSeenWhereItWasSeen) {
  test::Random random(5);
  const State x = state_before_landmark(random, 12);
  const auto initialised =
      initialise_landmark(rig(), kPixelNoise, x, {.landmark = 7, .pixels = projected(x)});
  ASSERT_TRUE(initialised);
  EXPECT_EQ(initialised->id, 7);
  EXPECT_TRUE(test::agree(initialised->p_world, x.landmarks[0].p_world, 1e-12));
}

// Position of a landmark by the pose's errors and its three numbers.
VectorXd initialised_at(const State& x, const VectorXd& error, const Eigen::Vector3d& rows) {
  return initialise_landmark(rig(), kPixelNoise, test::moved(kStandardChart, x, error),
                             observation(rows))
      ->p_world;
}

TEST(NewLandmark, HasTheDerivativesOfItsPosition) {
  test::Random random(6);
  const State x = test::random_state(random, {});
  const Eigen::Vector3d rows(640, 140, 40);
  const auto initialised = initialise_landmark(rig(), kPixelNoise, x, observation(rows));
  ASSERT_TRUE(initialised);
  const auto by_pose = [&](const VectorXd& e) { return initialised_at(x, e, rows); };
  EXPECT_TRUE(test::agree(initialised->d_pose, test::numeric_derivative(by_pose, VectorXd::Zero(6)),
                          1e-10));
  const auto by_rows = [&](const Eigen::Vector3d& r) {
    return initialised_at(x, VectorXd::Zero(6), r);
  };
  const MatrixXd D = test::numeric_derivative(by_rows, rows, 1e-4);
  const Eigen::Vector3d variances(kPixelNoise.u * kPixelNoise.u, kPixelNoise.v * kPixelNoise.v,
                                  kPixelNoise.disparity * kPixelNoise.disparity);
  EXPECT_TRUE(test::agree(initialised->noise, D * variances.asDiagonal() * D.transpose(), 1e-8, 0));
}

TEST(NewLandmark, ErrorOfANearOneIsDistributedAsStatedTogetherWithThePose) {
  test::Random random(7);
  const State x = test::random_state(random, {});
  const Eigen::Vector3d rows(640, 140, 120);  // 2 m away: linear over the noise of a pixel
  const auto initialised = initialise_landmark(rig(), kPixelNoise, x, observation(rows));
  ASSERT_TRUE(initialised);
  const MatrixXd P_pose = test::random_covariance(random, 6, 0.01);
  MatrixXd P(9, 9);
  P.topLeftCorner<6, 6>() = P_pose;
  P.bottomLeftCorner<3, 6>() = initialised->d_pose * P_pose;
  P.topRightCorner<6, 3>() = P.bottomLeftCorner<3, 6>().transpose();
  P.bottomRightCorner<3, 3>() =
      initialised->d_pose * P_pose * initialised->d_pose.transpose() + initialised->noise;
  // Truth and estimate are exchanged: true pose and pixels scatter around the estimate of the
  // filter.
  MatrixXd samples(9, 4000);
  const Eigen::Vector3d sigma(kPixelNoise.u, kPixelNoise.v, kPixelNoise.disparity);
  for (auto sample : samples.colwise()) {
    const VectorXd e = test::normal_of(random, P_pose);
    const Eigen::Vector3d noisy = rows + sigma.cwiseProduct(random.normal_vector(3));
    sample << e, initialised_at(x, e, noisy) - initialised->p_world;
  }
  EXPECT_TRUE(test::has_covariance(samples, P));
}

}  // namespace
}  // namespace chasles
