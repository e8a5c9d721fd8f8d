#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/truth_imu_fit.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/recording/inertial_testing.hpp>

// A truth in closed form, with errors in closed form, against the samples of an IMU with a bias.
namespace chasles {
namespace {

constexpr double kSeconds = 30;

Recording exact() { return test::swung({0, 0, -kStandardGravity}, kSeconds); }

// At 200 Hz: the attitude of the time t - `attitudes`, the position of the time t - `positions`,
// and millimetres of noise.
Trajectory late_truth(double attitudes, double positions, double noise = 0,
                      std::uint64_t seed = 17) {
  test::Random random(seed);
  Trajectory truth;
  for (int k = 20; 0.005 * k < kSeconds - 0.1; ++k) {
    const double t = 0.005 * k;
    truth.push_back(
        {.time = from_seconds(t),
         .pose = {test::swung_rotation(t - attitudes),
                  test::swung_pose(t - positions).pose.p + noise * random.normal_vector(3)}});
  }
  return truth;
}

TEST(TruthImuFit, OfATruthWithoutErrorsIsZero) {
  const auto fit = fit_truth_to_imu(late_truth(0, 0), exact().imu);
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->windows, 100);
  EXPECT_NEAR(fit->positions_late, 0, 1e-4);
  EXPECT_NEAR(fit->heading, 0, 0.05 * kRadians);
  EXPECT_NEAR(fit->tilt, 0, 0.05 * kRadians);
}

TEST(TruthImuFit, FindsTheTimesOfPositionsAndAttitudes) {
  const Recording r = exact();
  for (const double positions : {0.018, -0.007}) {
    const auto fit = fit_truth_to_imu(late_truth(0, positions), r.imu);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->positions_late, positions, 2e-4);
    const auto both = fit_truth_to_imu(late_truth(0.010, positions + 0.010), r.imu, 0.010);
    ASSERT_TRUE(both);
    EXPECT_NEAR(both->positions_late, positions + 0.010, 2e-4);
  }
}

TEST(TruthImuFit, FindsTheHeadingOfTheAttitudesAndTheTilt) {
  const Recording r = exact();
  Trajectory truth = late_truth(0, 0);
  for (StampedPose& row : truth) row.pose.R = so3::exp({0, 0, -0.02}) * row.pose.R;
  const auto turned = fit_truth_to_imu(truth, r.imu);
  ASSERT_TRUE(turned);
  EXPECT_NEAR(turned->heading, 0.02, 1e-3);
  const SE3 world{so3::exp({0.03, -0.04, 0}), Eigen::Vector3d::Zero()};
  truth = late_truth(0, 0);
  for (StampedPose& row : truth) row.pose = world * row.pose;
  const auto tilted = fit_truth_to_imu(truth, r.imu);
  ASSERT_TRUE(tilted);
  EXPECT_NEAR(tilted->tilt, 0.05, 1e-3);
  EXPECT_NEAR(tilted->heading, 0, 1e-3);
}

TEST(TruthImuFit, FindsThePointOnTheBody) {
  const Eigen::Vector3d point(0.08, -0.02, -0.12);
  Trajectory truth = late_truth(0, 0);
  for (StampedPose& row : truth) row.pose.p += row.pose.R * point;
  const auto fit = fit_truth_to_imu(truth, exact().imu);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(test::agree(fit->point, point, 2e-3));
  EXPECT_NEAR(fit->positions_late, 0, 1e-3);
}

// Over 40 draws of the noise, by chi-square.
TEST(TruthImuFit, ErrsWithinItsSigmas) {
  const Recording r = exact();
  constexpr int kDraws = 40;
  double time = 0, heading = 0;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const auto fit = fit_truth_to_imu(late_truth(0, 0.010, 0.001, seed), r.imu);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->positions_late_sigma, 0.002);
    time += std::pow((fit->positions_late - 0.010) / fit->positions_late_sigma, 2) / kDraws;
    heading += std::pow(fit->heading / fit->heading_sigma, 2) / kDraws;
  }
  const Band band = chi2_band(1, kDraws, 0.999);
  EXPECT_LT(time, band.high);
  EXPECT_GT(time, band.low);
  EXPECT_LT(heading, band.high);
  EXPECT_GT(heading, 0.5 * band.low) << "wider by the priors of the nuisance";
}

TEST(TruthImuFit, NeedsMotionAndSamples) {
  const Recording r = exact();
  const Trajectory truth = late_truth(0, 0);
  EXPECT_FALSE(fit_truth_to_imu({truth.begin(), truth.begin() + 400}, r.imu)) << "2 s";
  EXPECT_FALSE(fit_truth_to_imu({}, r.imu));
  EXPECT_FALSE(fit_truth_to_imu(truth, {}));
  Recording still = r;
  Trajectory rest = truth;
  for (StampedPose& row : rest) row.pose = {};
  for (ImuSample& sample : still.imu) {
    sample.specific_force_imu = {0, 0, kStandardGravity};
    sample.angular_rate_imu.setZero();
  }
  EXPECT_FALSE(fit_truth_to_imu(rest, still.imu)) << "a standstill";
}

}  // namespace
}  // namespace chasles
