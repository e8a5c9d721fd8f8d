#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/imu/strapdown.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/sim/inertial_imu.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr double kImuSigmas = 4;  // of the statistic under test; the seeds are fixed

const Vector3d kGravity(0, 0, -kStandardGravity);

struct Drift {
  double position, velocity, attitude;
};

// The largest errors of dead reckoning from the true start with ideal samples.
Drift drift(const Spline& motion, double rate, ImuConvention convention) {
  const std::vector<ImuSample> samples = ideal_imu(motion, rate, convention);
  ImuBuffer buffer({.convention = convention});
  for (const ImuSample& sample : samples) buffer.add(sample);
  const Motion start = motion_at(motion, 0);
  InertialState state{.world_T_imu = start.world_T_imu, .v_world = start.v_world};
  Drift worst{0, 0, 0};
  for (std::size_t k = 1; k < samples.size(); ++k) {
    for (const auto& interval : buffer.between(samples[k - 1].time, samples[k].time)) {
      state = integrate(state, interval, kGravity);
    }
    const Motion truth = motion_at(motion, to_seconds(samples[k].time - motion.start));
    const Eigen::Matrix3d turn = truth.world_T_imu.R.transpose() * state.world_T_imu.R;
    worst.position = std::max(worst.position, (truth.world_T_imu.p - state.world_T_imu.p).norm());
    worst.velocity = std::max(worst.velocity, (truth.v_world - state.v_world).norm());
    worst.attitude = std::max(worst.attitude, so3::log(turn).norm());
  }
  return worst;
}

const Spline& walk_motion() {
  static const Spline motion = [] {
    InertialScene scene = inertial_scene("hallway");
    scene.settings.rest_duration = 1;
    scene.settings.start_duration = 1.5;
    return inertial_motion(scene);
  }();
  return motion;
}

TEST(IdealImu, IntervalMeansCloseTheWalkExactly) {
  const Drift error = drift(walk_motion(), 100, ImuConvention::kIntervalMean);
  EXPECT_LT(error.position,
            2e-4);  // the mean of a force has no information on the time within the interval
  EXPECT_LT(error.velocity, 1e-9);
  EXPECT_LT(error.attitude, 1e-12);
}

TEST(IdealImu, InstantsCloseTheWalkWithTheSecondPowerOfTheInterval) {
  const Drift coarse = drift(walk_motion(), 100, ImuConvention::kInstant);
  const Drift fine = drift(walk_motion(), 200, ImuConvention::kInstant);
  const Drift finest = drift(walk_motion(), 1000, ImuConvention::kInstant);
  EXPECT_LT(coarse.position, 0.1);
  EXPECT_NEAR(coarse.position / fine.position, 4, 0.2);
  EXPECT_LT(finest.position, 1e-3);
}

// Kleinert & Stilla's samples: the attitude is exact, the force is that of instants.
TEST(IdealImu, InstantForcesWithIncrementalRotationsCloseTheWalk) {
  const Drift coarse = drift(walk_motion(), 100, ImuConvention::kInstantForce);
  const Drift fine = drift(walk_motion(), 200, ImuConvention::kInstantForce);
  EXPECT_LT(coarse.attitude, 1e-12);
  EXPECT_LT(coarse.position, 0.1);
  EXPECT_NEAR(coarse.position / fine.position, 4, 0.2);
}

TEST(IdealImu, AllConventionsCloseTheTurntable) {
  const Spline motion = inertial_motion(inertial_scene("turntable"));
  EXPECT_LT(drift(motion, 400, ImuConvention::kInstantForce).position, 1e-3);
  EXPECT_LT(drift(motion, 400, ImuConvention::kInstant).position, 1e-3);
  EXPECT_LT(drift(motion, 100, ImuConvention::kIntervalMean).position, 1e-3);
}

TEST(IdealImu, AtStandstillTheSpecificForcePointsUp) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    const auto samples = ideal_imu(walk_motion(), 100, convention);
    for (std::size_t k = 0; k < 50; ++k) {
      const SE3 pose = motion_at(walk_motion(), 0).world_T_imu;
      const Vector3d up = pose.R.transpose() * Vector3d(0, 0, kStandardGravity);
      EXPECT_TRUE(test::agree(samples[k].specific_force_imu, up, 1e-4));
      EXPECT_LT(samples[k].angular_rate_imu.norm(), 1e-4);
    }
  }
}

TEST(IdealImu, ACircleGivesTheCentripetalForceAndTheRate) {
  // Radius 2 m, 0.5 rad/s, to the left.
  Trajectory poses;
  for (int i = 0; i <= 4000; ++i) {
    const double angle = 0.5 * 0.005 * i;
    poses.push_back({from_seconds(0.005 * i),
                     {so3::exp({0, 0, angle}), {2 * std::sin(angle), -2 * std::cos(angle), 0}}});
  }
  const Spline motion = fit_spline(poses, 0.05);
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    const auto samples = ideal_imu(motion, 100, convention);
    ASSERT_EQ(samples.size(), 2001U);
    EXPECT_EQ(samples[7].time, from_seconds(0.07));
    for (std::size_t k = 100; k < 1900; ++k) {
      const Vector3d force(0, 2 * 0.5 * 0.5, kStandardGravity);
      EXPECT_TRUE(test::agree(samples[k].specific_force_imu, force, 1e-5, 1)) << k;
      EXPECT_TRUE(test::agree(samples[k].angular_rate_imu, Vector3d(0, 0, 0.5), 1e-7)) << k;
    }
  }
}

InertialSettings long_walk() {
  InertialSettings settings;
  settings.accelerometer_bias_sigma = 0.05;
  settings.sections = 8;
  settings.accelerometer_random_walk = 0.03;
  settings.gyroscope_random_walk = 0.002;
  return settings;
}

// Sum of squares of n numbers of variance sigma^2: chi-square with n degrees of freedom.
void expect_imu_variance(double sum_of_squares, double count, double sigma) {
  EXPECT_NEAR(sum_of_squares / (sigma * sigma), count, kImuSigmas * std::sqrt(2 * count));
}

TEST(SimulatedImu, NoiseAndBiasesHaveTheStatedStatistics) {
  for (const auto& [convention, name] : Choices<ImuConvention>::list) {
    SCOPED_TRACE(name);
    InertialSettings settings = long_walk();
    settings.imu_convention = convention;
    const Spline motion = inertial_motion({.name = "", .doc = "", .settings = settings});
    const SimulatedImu imu = simulate_imu(settings, motion, 3);
    const auto ideal = ideal_imu(motion, 100, settings.imu_convention);
    ASSERT_EQ(imu.samples.size(), ideal.size());
    double force = 0, rate = 0, force_walk = 0, rate_walk = 0, neighbours = 0;
    Vector3d last = Vector3d::Zero();
    for (std::size_t k = 0; k < ideal.size(); ++k) {
      const TrueMotion& truth = imu.truth[k];
      const Vector3d f = imu.samples[k].specific_force_imu - ideal[k].specific_force_imu -
                         truth.accelerometer_bias;
      force += f.squaredNorm();
      neighbours += f.dot(last);
      last = f;
      rate += (imu.samples[k].angular_rate_imu - ideal[k].angular_rate_imu - truth.gyroscope_bias)
                  .squaredNorm();
      if (k == 0) continue;
      const TrueMotion& before = imu.truth[k - 1];
      force_walk += (truth.accelerometer_bias - before.accelerometer_bias).squaredNorm();
      rate_walk += (truth.gyroscope_bias - before.gyroscope_bias).squaredNorm();
    }
    const double n = 3 * static_cast<double>(ideal.size());
    expect_imu_variance(force, n, 0.007355 * 10);  // 7.5 mg
    expect_imu_variance(rate, n, 9.774e-5 * 10);
    expect_imu_variance(force_walk, n - 3, 0.03 / 10);
    expect_imu_variance(rate_walk, n - 3, 0.002 / 10);
    EXPECT_LT(std::abs(neighbours) / std::pow(0.07355, 2), kImuSigmas * std::sqrt(n));
  }
}

TEST(SimulatedImu, TheFirstBiasesAreDrawnAndThenWalkOverTime) {
  InertialSettings settings = long_walk();
  settings.sections = 1;
  settings.imu_rate = 20;
  const Spline motion = inertial_motion({.name = "", .doc = "", .settings = settings});
  constexpr int kRuns = 400;
  double first_f = 0, first_w = 0, walk_f = 0, walk_w = 0, seconds = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const auto truth = simulate_imu(settings, motion, run).truth;
    first_f += truth.front().accelerometer_bias.squaredNorm();
    first_w += truth.front().gyroscope_bias.squaredNorm();
    walk_f += (truth.back().accelerometer_bias - truth.front().accelerometer_bias).squaredNorm();
    walk_w += (truth.back().gyroscope_bias - truth.front().gyroscope_bias).squaredNorm();
    seconds = to_seconds(truth.back().time - truth.front().time);
  }
  expect_imu_variance(first_f, 3 * kRuns, 0.05);
  expect_imu_variance(first_w, 3 * kRuns, 0.005236);
  expect_imu_variance(walk_f, 3 * kRuns, 0.03 * std::sqrt(seconds));
  expect_imu_variance(walk_w, 3 * kRuns, 0.002 * std::sqrt(seconds));
}

TEST(SimulatedImu, OneSourceOfNoiseDoesNotDisturbAnother) {
  const InertialSettings settings;
  InertialSettings calm = settings;
  calm.accelerometer_noise_density = calm.accelerometer_bias_sigma = 0;
  const auto a = simulate_imu(settings, walk_motion(), 5), b = simulate_imu(calm, walk_motion(), 5);
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    ASSERT_EQ(a.samples[k].angular_rate_imu, b.samples[k].angular_rate_imu);
    ASSERT_NE(a.samples[k].specific_force_imu, b.samples[k].specific_force_imu);
  }
}

TEST(SimulatedImu, TooManySamplesAreRejected) {
  InertialSettings settings;
  settings.sections = 100;
  settings.imu_rate = 1e4;
  EXPECT_THROW(simulate_inertial({.name = "", .doc = "", .settings = settings}), UsageError);
}

}  // namespace
}  // namespace chasles
