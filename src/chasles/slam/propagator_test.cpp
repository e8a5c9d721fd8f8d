#include <cmath>

#include <chasles/base/error.hpp>
#include <chasles/imu/imu_correction_testing.hpp>
#include <chasles/slam/propagator.hpp>
#include <chasles/slam/step_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kVelocitySigma = 0.3;
const ImuNoise kImuNoise{.accelerometer_noise_density = 0.02, .gyroscope_noise_density = 0};

// At the origin, level, with a known attitude and known biases.
SlamContext level_context() {
  State x;
  x.v_world = Vector3d(1, 2, 0);
  x.additive = Eigen::VectorXd::Zero(6);
  MatrixXd P = MatrixXd::Zero(15, 15);
  P.block<3, 3>(6, 6) = kVelocitySigma * kVelocitySigma * Matrix3d::Identity();
  return {.settings = {},
          .cameras = {},
          .filter = Ekf(kStandardChart, x, P, {.map = Ekf::Map::kFrozen})};
}

// A constant acceleration along x, 100 samples a second.
Propagator accelerating(const SlamContext& x, double acceleration, double seconds) {
  Propagator propagator(x.settings, kImuNoise, {});
  for (int i = 0; i <= 100 * seconds; ++i) {
    propagator.add(ImuSample{.time = from_seconds(0.01 * i),
                             .specific_force_imu = {acceleration, 1e-3 * (i % 2), kStandardGravity},
                             .angular_rate_imu = {1e-6 * (i % 3), 0, 0}});
  }
  return propagator;
}

// p = v t + a t^2 / 2; var p = var v t^2 + q t^3 / 3, cov(p, v) = var v t + q t^2 / 2.
TEST(Propagator, AConstantAccelerationHasItsClosedForm) {
  SlamContext x = level_context();
  Propagator propagator = accelerating(x, 0.5, 2);
  propagator.propagate(x, from_seconds(2));
  EXPECT_EQ(x.now, from_seconds(2));
  EXPECT_NEAR(x.state().world_T_imu.p.x(), 1 * 2 + 0.5 * 4 / 2, 1e-4);
  EXPECT_NEAR(x.state().v_world->x(), 1 + 0.5 * 2, 1e-4);
  const double variance = kVelocitySigma * kVelocitySigma, q = 0.02 * 0.02;
  const MatrixXd P = x.filter.covariance();
  EXPECT_NEAR(P(3, 3), variance * 4 + q * 8 / 3, 1e-6);
  EXPECT_NEAR(P(3, 6), variance * 2 + q * 4 / 2, 1e-6);
  EXPECT_NEAR(P(6, 6), variance + q * 2, 1e-6);
  const NavState now = propagator.motion(x);
  EXPECT_NEAR(now.covariance(3, 3), P(3, 3), 1e-12);
}

TEST(Propagator, ItsStepsAddUp) {
  SlamContext at_once = level_context(), in_steps = level_context();
  Propagator a = accelerating(at_once, 0.5, 1), b = accelerating(in_steps, 0.5, 1);
  a.propagate(at_once, from_seconds(1));
  for (int i = 1; i <= 7; ++i) b.propagate(in_steps, from_seconds(i / 7.0));
  EXPECT_LT(test::distance(at_once.state(), in_steps.state()), 1e-6);
  EXPECT_LT(test::covariance_difference(in_steps.filter.covariance(), at_once.filter.covariance()),
            1e-6);
}

// The position at 0.5 s, known to a centimetre.
TEST(Propagator, AMeasurementAppliesAtItsOwnTime) {
  const auto model = [](const State& x) {
    Measurement z;
    z.core_column = 3;
    z.residual = Vector3d(1, 1, 0) - x.world_T_imu.p;
    z.d_core = Matrix3d::Identity();
    z.noise = 1e-4 * Matrix3d::Identity();
    return z;
  };
  SlamContext x = level_context();
  Propagator propagator = accelerating(x, 0, 1);
  propagator.add(TimedMeasurement{.time = from_seconds(0.5), .model = model});
  propagator.add(TimedMeasurement{.time = from_seconds(-0.1), .model = model});
  propagator.add(TimedMeasurement{.time = from_seconds(1.5), .model = model});
  propagator.propagate(x, from_seconds(1));
  EXPECT_EQ(propagator.timed_counts().used, 1);
  EXPECT_EQ(propagator.timed_counts().late, 1);
  EXPECT_EQ(propagator.timed_waiting(), 1);

  SlamContext by_hand = level_context();
  Propagator other = accelerating(by_hand, 0, 1);
  other.propagate(by_hand, from_seconds(0.5));
  const Measurement z = model(by_hand.state());
  by_hand.filter.update({&z, 1});
  other.propagate(by_hand, from_seconds(1));
  EXPECT_LT(test::distance(x.state(), by_hand.state()), 1e-9);
  EXPECT_GT(test::distance(x.state(), level_context().state()), 0.5);
}

// A state with a time offset of 20 ms, sigma 5 ms, and samples that change quickly.
SlamContext offset_context(double time_offset) {
  State x;
  x.world_T_imu = {so3::exp({0.1, -0.2, 0.3}), {1, 2, 3}};
  x.v_world = Vector3d(1, 2, 0);
  x.additive = Eigen::VectorXd::Constant(6, 0.01);
  x.time_offset = time_offset;
  MatrixXd P = 1e-4 * MatrixXd::Identity(16, 16);
  P(15, 15) = 25e-6;
  return {.settings = {},
          .cameras = {},
          .filter = Ekf(kStandardChart, x, P, {.map = Ekf::Map::kFrozen})};
}

Propagator turning(const SlamContext& x) {
  Propagator propagator(x.settings, {}, {});
  for (int i = 0; i <= 200; ++i) {
    const double t = 0.005 * i;
    propagator.add(ImuSample{
        .time = from_seconds(t),
        .specific_force_imu = {2 * std::sin(2 * t), 1 + t, kStandardGravity - std::cos(3 * t)},
        .angular_rate_imu = {0.5 * std::cos(2 * t), 0.4 * t, 1 - std::sin(t)}});
  }
  return propagator;
}

// From the start at 0 of the IMU's clock to two images, with the offset of the context.
SlamContext at_two_images(double time_offset) {
  SlamContext x = offset_context(time_offset);
  x.now = -from_seconds(time_offset);
  Propagator propagator = turning(x);
  propagator.propagate(x, from_seconds(0.4));
  propagator.propagate(x, from_seconds(0.7));
  return x;
}

// The state is that of the image by its own clock, so an error of the offset moves it by what the
// motion is after that time. Without noise, P(state, offset) = d state / d offset * P(offset); the
// derivative by propagating again with other offsets, which step over samples.
TEST(Propagator, AnErrorOfTheTimeOffsetMovesTheState) {
  const SlamContext x = at_two_images(0.02);
  const auto state = [&](const Eigen::VectorXd& offset) -> Eigen::VectorXd {
    const SlamContext y = at_two_images(0.02 + offset[0]);
    Eigen::VectorXd e(9);
    e << so3::log(y.state().world_T_imu.R * x.state().world_T_imu.R.transpose()),
        y.state().world_T_imu.p - x.state().world_T_imu.p, *y.state().v_world - *x.state().v_world;
    return e;
  };
  const Eigen::VectorXd expected =
      test::numeric_derivative(state, Eigen::VectorXd::Zero(1), 1e-3).col(0);
  const Eigen::VectorXd actual = x.filter.covariance().block(0, 15, 9, 1) / 25e-6;
  EXPECT_GT(expected.head<3>().norm(), 0.3);
  EXPECT_LT((actual - expected).norm(), 5e-3 * expected.norm()) << actual << "\n" << expected;
  EXPECT_NEAR(x.filter.covariance()(15, 15), 25e-6, 1e-15) << "the offset is constant";
}

// The samples that the filter integrates are those of the IMU's clock.
TEST(Propagator, WithATimeOffsetTheStateIsThatOfTheImage) {
  const SlamContext x = at_two_images(0.02);
  SlamContext without = offset_context(0);
  Propagator propagator = turning(without);
  propagator.propagate(without, from_seconds(0.72));
  EXPECT_LT(test::distance(x.state().world_T_imu, without.state().world_T_imu), 1e-9);
}

// By the IMU's clock the offset moves nothing: an error of it is none of the motion's.
TEST(Propagator, TheMotionByTheClockOfTheImuHasNoErrorOfTheOffset) {
  SlamContext x = offset_context(0.02);
  x.now = -from_seconds(0.02);
  Propagator propagator = turning(x);
  propagator.propagate(x, from_seconds(0.4));
  SlamContext known = offset_context(0.02);
  State fixed = known.state();
  fixed.time_offset.reset();
  known.filter =
      Ekf(kStandardChart, fixed, 1e-4 * MatrixXd::Identity(15, 15), {.map = Ekf::Map::kFrozen});
  Propagator other = turning(known);
  other.propagate(known, from_seconds(0.42));
  const NavState by_clock = propagator.motion(x), expected = other.motion(known);
  EXPECT_LT(test::covariance_difference(by_clock.covariance, expected.covariance), 1e-6);
  const MatrixXd of_image = x.filter.core_covariance().topLeftCorner<15, 15>();
  EXPECT_GT(test::covariance_difference(of_image, expected.covariance), 0.1);
}

// With an IMU whose errors the state knows: motion, readout and the column of the time offset are
// those of a perfect one.
TEST(Propagator, CorrectsEachSampleThatItUses) {
  test::Random random(1);
  ImuCorrection errors;
  errors.add(0.05 * random.normal_vector(errors.size()));
  Camera camera = test::euroc_camera();
  camera.shutter.readout = 0.03;
  const auto after_two_images = [&](const std::optional<ImuCorrection>& imu) {
    SlamContext x = offset_context(0.02);
    State start = x.state();
    start.imu = imu;
    MatrixXd P = MatrixXd::Zero(start.core_size(), start.core_size());
    P.topLeftCorner<16, 16>() = x.filter.core_covariance();
    x.filter = Ekf(kStandardChart, start, P, {.map = Ekf::Map::kFrozen});
    x.cameras = {camera};
    x.now = -from_seconds(0.02);
    Propagator propagator(x.settings, kImuNoise, {});
    for (int i = 0; i <= 200; ++i) {
      const double t = 0.005 * i;
      const ImuSample sample{.time = from_seconds(t),
                             .specific_force_imu = {2 * std::sin(2 * t), 1 + t, 9},
                             .angular_rate_imu = {0.5 * std::cos(2 * t), 0.4 * t, 1}};
      propagator.add(imu ? test::as_measured(*imu, sample) : sample);
    }
    propagator.propagate(x, from_seconds(0.4));
    propagator.propagate(x, from_seconds(0.7));
    const NavState motion = propagator.motion(x);
    return std::pair(std::move(x), motion);
  };
  const auto [x, motion] = after_two_images(errors);
  const auto [perfect, expected] = after_two_images(std::nullopt);
  EXPECT_LT(test::distance(x.state().world_T_imu, perfect.state().world_T_imu), 1e-12);
  EXPECT_LT((*x.state().v_world - *perfect.state().v_world).norm(), 1e-12);
  const ReadoutMotion &readout = x.state().readout, &right = perfect.state().readout;
  EXPECT_LT((readout.rate - right.rate).norm(), 1e-12);
  EXPECT_LT((readout.acceleration - right.acceleration).norm(), 1e-11);
  EXPECT_GT(right.rate.norm(), 0.1);
  EXPECT_LT(test::covariance_difference(x.filter.core_covariance().topLeftCorner<16, 16>(),
                                        perfect.filter.core_covariance()),
            1e-9);
  EXPECT_LT(test::covariance_difference(motion.covariance, expected.covariance), 1e-9);
}

TEST(Propagator, NeedsSamplesAndATimeThatRises) {
  SlamContext x = level_context();
  Propagator without(x.settings, kImuNoise, {});
  EXPECT_THROW(without.propagate(x, from_seconds(0.1)), InputError);
  Propagator propagator = accelerating(x, 0, 1);
  propagator.propagate(x, from_seconds(0.5));
  EXPECT_THROW(propagator.propagate(x, from_seconds(0.4)), InputError);
}

TEST(Propagator, CoversWhatTheSamplesReachOnTheirClock) {
  SlamContext x = level_context();
  Propagator propagator = accelerating(x, 0, 1);
  EXPECT_TRUE(propagator.covers(x, from_seconds(1.01))) << "without an offset a frame never waits";
  x.settings.time_offset = 0.02;
  EXPECT_FALSE(propagator.covers(x, from_seconds(0.99)));
  EXPECT_TRUE(propagator.covers(x, from_seconds(0.97)));
}

}  // namespace
}  // namespace chasles
