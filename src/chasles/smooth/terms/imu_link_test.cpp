#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>
#include <chasles/smooth/terms/imu_link.hpp>

namespace chasles {
namespace {

using test::integrated;
using test::moved;

using test::agree;
using test::Random;

const Eigen::Vector3d kGravity(0, 0, -kStandardGravity);
const ImuNoise kNoise{.accelerometer_noise_density = 0.01,
                      .accelerometer_random_walk = 0.02,
                      .gyroscope_noise_density = 0.003,
                      .gyroscope_random_walk = 0.001};

std::vector<ImuInterval> random_intervals(Random& random, int count) {
  std::vector<ImuInterval> intervals;
  for (int i = 0; i < count; ++i) {
    intervals.push_back({.tau = random.uniform(0.004, 0.012),
                         .specific_force_imu = Eigen::Vector3d(0, 0, 9.8) + random.normal_vector(3),
                         .angular_rate_imu = random.normal_vector(3)});
  }
  return intervals;
}

InertialState random_link_motion(Random& random) {
  return {.world_T_imu = {.R = so3::exp(random.normal_vector(3)), .p = 5 * random.normal_vector(3)},
          .v_world = random.normal_vector(3),
          .accelerometer_bias = 0.1 * random.normal_vector(3),
          .gyroscope_bias = 0.05 * random.normal_vector(3)};
}

TEST(ImuLink, TheResidualVanishesWhereTheSamplesLead) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto intervals = random_intervals(random, 12);
    // Made at other biases, on which the mean does not depend.
    const ImuLink link = imu_link(intervals, random.normal_vector(6), kNoise);
    const InertialState now = random_link_motion(random);
    const Vector15d r = link_residual(link, now, integrated(now, intervals), kGravity);
    EXPECT_LT(r.cwiseAbs().maxCoeff(), 1e-6) << "in sigmas";
  }
}

TEST(ImuLink, DerivativesAreTheNumericOnes) {
  Random random(2);
  for (int trial = 0; trial < 10; ++trial) {
    const auto intervals = random_intervals(random, 8);
    ImuLink link = imu_link(intervals, Vector6d::Zero(), kNoise);
    link.whitening.setIdentity();
    const InertialState now = random_link_motion(random);
    const InertialState next = moved(integrated(now, intervals), 0.3 * random.normal_vector(15));
    LinkDerivatives d;
    link_residual(link, now, next, kGravity, &d);
    const Vector15d zero = Vector15d::Zero();
    EXPECT_TRUE(agree(d.now,
                      test::numeric_derivative(
                          [&](const Vector15d& e) -> Eigen::VectorXd {
                            return link_residual(link, moved(now, e), next, kGravity);
                          },
                          zero),
                      1e-8));
    EXPECT_TRUE(agree(d.next,
                      test::numeric_derivative(
                          [&](const Vector15d& e) -> Eigen::VectorXd {
                            return link_residual(link, now, moved(next, e), kGravity);
                          },
                          zero),
                      1e-8));
  }
}

TEST(ImuLink, TheDerivativeByTheImuIsTheNumericOne) {
  Random random(8);
  for (int groups = 1; groups < 8; ++groups) {
    const ImuLink measured = imu_link(random_intervals(random, 8), Vector6d::Zero(), kNoise);
    const InertialState now = random_link_motion(random);
    const InertialState next =
        moved(integrated(now, measured.intervals), 0.3 * random.normal_vector(15));
    ImuCorrection imu{.has_scale = (groups & 1) != 0,
                      .has_misalignment = (groups & 2) != 0,
                      .has_g_sensitivity = (groups & 4) != 0};
    imu.add(0.05 * random.normal_vector(imu.size()));
    const auto residual = [&](const Eigen::VectorXd& errors) -> Eigen::VectorXd {
      ImuCorrection other = imu;
      other.add(errors);
      return link_residual(corrected(other, measured), now, next, kGravity);
    };
    EXPECT_TRUE(agree(Eigen::MatrixXd(link_by_imu(measured, imu, now, next)),
                      test::numeric_derivative(residual, Eigen::VectorXd::Zero(imu.size()), 1e-3),
                      1e-8));
  }
}

TEST(ImuLink, WhiteningIsTheInverseRootOfTheCovariance) {
  Random random(3);
  const auto intervals = random_intervals(random, 10);
  const Vector6d biases = 0.1 * random.normal_vector(6);
  const ImuLink link = imu_link(intervals, biases, kNoise);
  const Matrix15d P = link_covariance(intervals, biases, kNoise);
  EXPECT_TRUE(agree(Matrix15d(link.whitening * P * link.whitening.transpose()),
                    Matrix15d(Matrix15d::Identity()), 1e-8));
}

TEST(ImuLink, TheCovarianceIsThatOfNoisySamples) {
  Random random(4);
  const auto intervals = random_intervals(random, 10);
  const InertialState now = random_link_motion(random);
  const ImuLink link = imu_link(intervals, now.biases(), kNoise);
  constexpr int kRuns = 4000;
  Eigen::MatrixXd residuals(15, kRuns);
  for (int run = 0; run < kRuns; ++run) {
    // The true motion: the samples minus their noise and minus biases that walk after each of them.
    InertialState state = now;
    for (ImuInterval interval : intervals) {
      const double white = 1 / std::sqrt(interval.tau), walk = std::sqrt(interval.tau);
      interval.specific_force_imu +=
          white * kNoise.accelerometer_noise_density * random.normal_vector(3);
      interval.angular_rate_imu += white * kNoise.gyroscope_noise_density * random.normal_vector(3);
      state = integrate(state, interval, kGravity);
      state.accelerometer_bias += walk * kNoise.accelerometer_random_walk * random.normal_vector(3);
      state.gyroscope_bias += walk * kNoise.gyroscope_random_walk * random.normal_vector(3);
    }
    residuals.col(run) = link_residual(link, now, state, kGravity);
  }
  EXPECT_TRUE(test::has_covariance(residuals, Eigen::MatrixXd::Identity(15, 15)));
}

TEST(ImuLink, OneSampleIsEnough) {
  Random random(5);
  const ImuLink link = imu_link(random_intervals(random, 1), Vector6d::Zero(), kNoise);
  EXPECT_TRUE(link.whitening.allFinite());
}

TEST(ImuLink, WithoutWalkTheBiasesAreHeldNotSingular) {
  Random random(6);
  ImuNoise noise = kNoise;
  noise.accelerometer_random_walk = noise.gyroscope_random_walk = 0;
  EXPECT_TRUE(imu_link(random_intervals(random, 9), Vector6d::Zero(), noise).whitening.allFinite());
}

TEST(ImuLink, NoNoiseOrNoNumbersAreRejected) {
  Random random(7);
  auto intervals = random_intervals(random, 9);
  EXPECT_THROW(imu_link(intervals, Vector6d::Zero(), ImuNoise{}), InputError);
  EXPECT_THROW(imu_link({}, Vector6d::Zero(), kNoise), InputError);
  intervals[3].angular_rate_imu.x() = std::nan("");
  EXPECT_THROW(imu_link(intervals, Vector6d::Zero(), kNoise), InputError);
}

}  // namespace
}  // namespace chasles
