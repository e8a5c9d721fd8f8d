#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <chasles/imu/strapdown.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using Vector15d = Eigen::Matrix<double, 15, 1>;

constexpr int kRotation = 0, kPosition = 3, kVelocity = 6, kAccelerometer = 9, kGyroscope = 12;

const Eigen::Vector3d kGravityWorld(0, 0, -kStandardGravity);
// Not along an axis, so that every component is tested.
const Eigen::Vector3d kTiltedGravity(2.1, -3.3, -8.9);
const ImuNoise kNoise{.accelerometer_noise_density = 2e-3,
                      .accelerometer_random_walk = 3e-3,
                      .gyroscope_noise_density = 2e-4,
                      .gyroscope_random_walk = 3e-5};

InertialState random_state(test::Random& random) {
  return {.world_T_imu = {so3::exp(2 * random.axis()), 3 * random.normal_vector(3)},
          .v_world = 4 * random.normal_vector(3),
          .accelerometer_bias = 0.1 * random.normal_vector(3),
          .gyroscope_bias = 0.05 * random.normal_vector(3)};
}

ImuInterval random_interval(test::Random& random, double tau, double rate) {
  return {.tau = tau,
          .specific_force_imu = 10 * random.axis(),
          .angular_rate_imu = rate * random.axis()};
}

// Adds the error d to a state, and the error between two states: the reference chart.
InertialState retract(const InertialState& x, const Vector15d& d) {
  return {.world_T_imu = {so3::exp(d.segment<3>(kRotation)) * x.world_T_imu.R,
                          x.world_T_imu.p + d.segment<3>(kPosition)},
          .v_world = x.v_world + d.segment<3>(kVelocity),
          .accelerometer_bias = x.accelerometer_bias + d.segment<3>(kAccelerometer),
          .gyroscope_bias = x.gyroscope_bias + d.segment<3>(kGyroscope)};
}
Vector15d local(const InertialState& x, const InertialState& y) {
  Vector15d d;
  d << so3::log(y.world_T_imu.R * x.world_T_imu.R.transpose()), y.world_T_imu.p - x.world_T_imu.p,
      y.v_world - x.v_world, y.accelerometer_bias - x.accelerometer_bias,
      y.gyroscope_bias - x.gyroscope_bias;
  return d;
}

InertialState integrate_for(InertialState x, const ImuInterval& interval, int steps) {
  for (int i = 0; i < steps; ++i) x = integrate(x, interval, kGravityWorld);
  return x;
}

TEST(Strapdown, AStandstillStaysOne) {
  test::Random random(1);
  InertialState start = random_state(random);
  start.v_world.setZero();
  const ImuInterval interval{.tau = 0.005,
                             .specific_force_imu = start.accelerometer_bias -
                                                   start.world_T_imu.R.transpose() * kGravityWorld,
                             .angular_rate_imu = start.gyroscope_bias};
  const InertialState end = integrate_for(start, interval, 12000);
  EXPECT_TRUE(test::agree(local(start, end), Vector15d::Zero(), 1e-9));
}

TEST(Strapdown, TumblingFreeFallIsAParabola) {
  test::Random random(2);
  const InertialState start = random_state(random);
  const ImuInterval interval{.tau = 0.01,
                             .specific_force_imu = start.accelerometer_bias,
                             .angular_rate_imu = Eigen::Vector3d(3, -2, 5)};
  const InertialState end = integrate_for(start, interval, 300);
  EXPECT_TRUE(test::agree(end.world_T_imu.p,
                          start.world_T_imu.p + 3 * start.v_world + 4.5 * kGravityWorld, 1e-12));
  EXPECT_TRUE(test::agree(end.v_world, start.v_world + 3 * kGravityWorld, 1e-12));
}

TEST(Strapdown, ConstantRateTurnsAboutItsAxis) {
  test::Random random(3);
  const InertialState start = random_state(random);
  const Eigen::Vector3d rate(0.4, -0.7, 1.1);
  const ImuInterval interval{.tau = 0.01, .angular_rate_imu = rate + start.gyroscope_bias};
  const InertialState end = integrate_for(start, interval, 500);
  EXPECT_TRUE(test::agree(end.world_T_imu.R, start.world_T_imu.R * so3::exp(5 * rate), 1e-12));
}

// On a circle with the nose along the velocity, specific force and rate are constant in IMU axes.
// The map then has no discretisation error, regardless of the number of steps.
TEST(Strapdown, CircleIsExactForAnyStep) {
  constexpr double kRadius = 5, kRate = 2, kTurnPeriod = 2 * std::numbers::pi / kRate;
  const Eigen::Matrix3d axes = so3::exp(Eigen::Vector3d(0.3, -0.2, 0.9));  // of the IMU in the car
  const Eigen::Vector3d centripetal(0, kRadius * kRate * kRate, 0);
  for (const int steps : {7, 100, 2000}) {
    const ImuInterval interval{
        .tau = kTurnPeriod / steps,
        .specific_force_imu = axes.transpose() * (centripetal - kGravityWorld),
        .angular_rate_imu = axes.transpose() * Eigen::Vector3d(0, 0, kRate)};
    InertialState x{.world_T_imu = {axes, {0, -kRadius, 0}}, .v_world = {kRadius * kRate, 0, 0}};
    for (int i = 1; i <= steps; ++i) {
      x = integrate(x, interval, kGravityWorld);
      const Eigen::Matrix3d turn =
          so3::exp(Eigen::Vector3d(0, 0, 2 * std::numbers::pi * i / steps));
      ASSERT_TRUE(test::agree(x.world_T_imu.R, turn * axes, 1e-12));
      ASSERT_TRUE(test::agree(x.world_T_imu.p, turn * Eigen::Vector3d(0, -kRadius, 0), 1e-11));
      ASSERT_TRUE(test::agree(x.v_world, turn * Eigen::Vector3d(kRadius * kRate, 0, 0), 1e-11));
    }
  }
}

TEST(Strapdown, TwoHalvesAreTheWholeInMeanAndTransition) {
  test::Random random(4);
  for (const double tau : {1e-4, 5e-3, 0.1, 0.5}) {
    for (const double rate : {0.0, 1e-6, 0.5, 4.0, 20.0}) {
      const InertialState x = random_state(random);
      const ImuInterval whole = random_interval(random, tau, rate);
      ImuInterval half = whole;
      half.tau /= 2;
      const StrapdownStep one = strapdown(x, whole, kTiltedGravity, kNoise);
      const StrapdownStep first = strapdown(x, half, kTiltedGravity, kNoise);
      const StrapdownStep second = strapdown(first.state, half, kTiltedGravity, kNoise);
      EXPECT_TRUE(test::agree(local(one.state, second.state), Vector15d::Zero(), 1e-13));
      EXPECT_TRUE(test::agree(second.F * first.F, one.F, 1e-13));
      EXPECT_TRUE(test::agree(second.F * first.d_gravity + second.d_gravity, one.d_gravity, 1e-14));
    }
  }
}

TEST(Strapdown, StepAndIntegrateGiveTheSameBits) {
  test::Random random(5);
  const InertialState x = random_state(random);
  const ImuInterval interval = random_interval(random, 0.01, 2);
  const InertialState mean = integrate(x, interval, kTiltedGravity);
  const InertialState step = strapdown(x, interval, kTiltedGravity, kNoise).state;
  EXPECT_EQ(mean.world_T_imu.R, step.world_T_imu.R);
  EXPECT_EQ(mean.world_T_imu.p, step.world_T_imu.p);
  EXPECT_EQ(mean.v_world, step.v_world);
}

// Derivative of integrate() by the three coordinates from `column` on. `step` corresponds to a
// rotation of about 2e-3 rad, or to a change of 1 of an affine argument.
Eigen::MatrixXd numeric_columns(const InertialState& x, const ImuInterval& interval, int column) {
  const InertialState at = integrate(x, interval, kTiltedGravity);
  const auto f = [&](const Eigen::Vector3d& part) {
    Vector15d d = Vector15d::Zero();
    d.segment<3>(column) = part;
    return local(at, integrate(retract(x, d), interval, kTiltedGravity));
  };
  const double step = column == kRotation ? 2e-3 : column == kGyroscope ? 2e-3 / interval.tau : 1.0;
  return test::numeric_derivative(f, Eigen::Vector3d::Zero(), step);
}

// Block by block, each relative to its own size (down to tau^3 / 6). The start is a standstill at
// the origin: otherwise the round-off of the position hides the smallest blocks.
TEST(Strapdown, TransitionIsTheDerivativeOfTheMean) {
  test::Random random(6);
  for (const double tau : {1e-4, 2.5e-3, 1e-2, 0.1, 0.5}) {
    for (const double rate : {0.0, 1e-9, 1e-3, 0.3, 3.999, 4.001, 20.0}) {
      SCOPED_TRACE(::testing::Message() << "tau " << tau << " rate " << rate);
      InertialState x = random_state(random);
      x.world_T_imu.p.setZero();
      x.v_world.setZero();
      ImuInterval interval = random_interval(random, tau, rate);
      interval.angular_rate_imu += x.gyroscope_bias;
      const Matrix15d F = strapdown(x, interval, kTiltedGravity, kNoise).F;
      for (int column = 0; column < 15; column += 3) {
        const Eigen::MatrixXd expected = numeric_columns(x, interval, column);
        for (int row = 0; row < 15; row += 3) {
          const Eigen::Matrix3d block = F.block<3, 3>(row, column);
          if (block.isZero(0)) {
            EXPECT_LT(expected.middleRows<3>(row).cwiseAbs().maxCoeff(), 1e-11 * tau * tau);
          } else {
            EXPECT_TRUE(test::agree(block, expected.middleRows<3>(row), 1e-9, 1e-300))
                << "block " << row << ", " << column;
          }
        }
      }
    }
  }
}

TEST(Strapdown, TransitionHoldsFarFromTheOriginAndMoving) {
  test::Random random(7);
  const InertialState x = random_state(random);
  const ImuInterval interval = random_interval(random, 0.2, 6);
  const Matrix15d F = strapdown(x, interval, kTiltedGravity, kNoise).F;
  for (int column = 0; column < 15; column += 3) {
    EXPECT_TRUE(test::agree(F.middleCols<3>(column), numeric_columns(x, interval, column), 1e-10));
  }
}

TEST(Strapdown, GravityColumnsAreTheDerivativeByGravity) {
  test::Random random(8);
  const InertialState x = random_state(random);
  const ImuInterval interval = random_interval(random, 0.3, 2);
  const InertialState at = integrate(x, interval, kTiltedGravity);
  const auto f = [&](const Eigen::Vector3d& g) { return local(at, integrate(x, interval, g)); };
  EXPECT_TRUE(test::agree(strapdown(x, interval, kTiltedGravity, kNoise).d_gravity,
                          test::numeric_derivative(f, kTiltedGravity), 1e-11));
}

// Kleinert & Stilla (19)-(22) with their exact derivative of docs/derivations.md, D24.
Matrix15d kleinert_stilla(const InertialState& x, const ImuInterval& interval) {
  const double tau = interval.tau;
  const Eigen::Matrix3d& C = x.world_T_imu.R;
  const Eigen::Vector3d f = interval.specific_force_imu - x.accelerometer_bias;
  const Eigen::Vector3d w = interval.angular_rate_imu - x.gyroscope_bias;
  Matrix15d F = Matrix15d::Identity();
  F.block<3, 3>(kPosition, kVelocity) = tau * Eigen::Matrix3d::Identity();
  F.block<3, 3>(kPosition, kRotation) = -tau * tau / 2 * hat(C * f);
  F.block<3, 3>(kPosition, kAccelerometer) = -tau * tau / 2 * C;
  F.block<3, 3>(kVelocity, kRotation) = -tau * hat(C * f);
  F.block<3, 3>(kVelocity, kAccelerometer) = -tau * C;
  F.block<3, 3>(kRotation, kGyroscope) = -tau * C * so3::left_jacobian(w * tau);
  return F;
}

TEST(Strapdown, TransitionIsKleinertAndStillasToFirstOrder) {
  test::Random random(9);
  const InertialState x = random_state(random);
  ImuInterval interval = random_interval(random, 0, 2);
  for (const double tau : {1e-2, 1e-3, 1e-4}) {
    interval.tau = tau;
    const Matrix15d F = strapdown(x, interval, kTiltedGravity, kNoise).F;
    const Matrix15d difference = F - kleinert_stilla(x, interval);
    // The largest is tau^2/2 of C [w x f] (|w x f| < 20) and of C [f] (|f| about 10).
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 12 * tau * tau);
    EXPECT_GT(difference.cwiseAbs().maxCoeff(), 1 * tau * tau);
  }
}

// The covariance of a step, from the derivative of the mean by the samples instead of the biases.
TEST(Strapdown, NoiseEntersThroughTheSamples) {
  test::Random random(10);
  for (const double tau : {0.0025, 0.1}) {
    const InertialState x = random_state(random);
    const ImuInterval interval = random_interval(random, tau, 3);
    const InertialState at = integrate(x, interval, kTiltedGravity);
    const auto f = [&](const Vector6d& n) {
      ImuInterval noisy = interval;
      noisy.specific_force_imu += n.head<3>();
      noisy.angular_rate_imu += n.tail<3>();
      return local(at, integrate(x, noisy, kTiltedGravity));
    };
    const Eigen::MatrixXd N = test::numeric_derivative(f, Vector6d::Zero(), 1e-2);
    const auto variance = [&](double density) { return density * density / tau; };
    Vector6d variances;
    variances << Eigen::Vector3d::Constant(variance(kNoise.accelerometer_noise_density)),
        Eigen::Vector3d::Constant(variance(kNoise.gyroscope_noise_density));
    Matrix15d expected = N * variances.asDiagonal() * N.transpose();
    for (int i = 0; i < 3; ++i) {
      expected(kAccelerometer + i, kAccelerometer + i) = tau * 9e-6;
      expected(kGyroscope + i, kGyroscope + i) = tau * 9e-10;
    }
    const Matrix15d Q = strapdown(x, interval, kTiltedGravity, kNoise).Q;
    // Rotation, position, velocity and biases differ by orders of magnitude: the comparison is
    // scaled.
    const Vector15d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_TRUE(test::agree(scale.asDiagonal() * Q * scale.asDiagonal(),
                            scale.asDiagonal() * expected * scale.asDiagonal(), 1e-8));
  }
}

// At a standstill the covariances have closed forms: white noise integrated once and twice, and
// random walks integrated up to three times. Many short steps converge to them.
TEST(Strapdown, CovarianceOfManyStepsIsThatOfTheContinuousProcesses) {
  constexpr double kSeconds = 2;
  constexpr int kSteps = 2000;
  const ImuInterval standstill{.tau = kSeconds / kSteps, .specific_force_imu = -kGravity};
  Matrix15d P = Matrix15d::Zero();
  InertialState x;
  for (int i = 0; i < kSteps; ++i) {
    const StrapdownStep step = strapdown(x, standstill, kGravityWorld, kNoise);
    P = step.F * P * step.F.transpose() + step.Q;
    x = step.state;
  }
  const double T = kSeconds, sa = 4e-6, wa = 9e-6, sg = 4e-8, wg = 9e-10;  // densities squared
  const auto near = [&](int i, double expected) { EXPECT_NEAR(P(i, i) / expected, 1, 2e-3) << i; };
  near(kRotation + 2, sg * T + wg * std::pow(T, 3) / 3);
  near(kVelocity + 2, sa * T + wa * std::pow(T, 3) / 3);
  near(kPosition + 2, sa * std::pow(T, 3) / 3 + wa * std::pow(T, 5) / 20);
  const double tilt = sg * std::pow(T, 3) / 3 + wg * std::pow(T, 5) / 20;  // of its integral
  near(kVelocity, sa * T + wa * std::pow(T, 3) / 3 + std::pow(kStandardGravity, 2) * tilt);
  near(kAccelerometer, wa * T);
  near(kGyroscope, wg * T);
}

TEST(Strapdown, CovarianceExplainsWhatNoisySamplesDo) {
  constexpr int kRuns = 3000, kSteps = 20;
  constexpr double kTau = 0.01;
  test::Random random(11);
  const InertialState start = random_state(random);
  const auto truth = [](int i) {
    return ImuInterval{.tau = kTau,
                       .specific_force_imu = {3 * std::sin(0.4 * i), -2, 9},
                       .angular_rate_imu = {5, 4 * std::cos(0.3 * i), -3}};
  };
  Matrix15d P = Matrix15d::Zero();
  InertialState end = start;
  for (int i = 0; i < kSteps; ++i) {
    const StrapdownStep step = strapdown(end, truth(i), kTiltedGravity, kNoise);
    P = step.F * P * step.F.transpose() + step.Q;
    end = step.state;
  }
  const Eigen::LLT<Matrix15d> factor(P);
  ASSERT_EQ(factor.info(), Eigen::Success);
  const auto draw = [&](double sigma) { return Eigen::Vector3d(sigma * random.normal_vector(3)); };
  Vector15d squares = Vector15d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    InertialState x = start;
    for (int i = 0; i < kSteps; ++i) {
      ImuInterval interval = truth(i);
      interval.specific_force_imu += draw(kNoise.accelerometer_noise_density / std::sqrt(kTau));
      interval.angular_rate_imu += draw(kNoise.gyroscope_noise_density / std::sqrt(kTau));
      x = integrate(x, interval, kTiltedGravity);
      x.accelerometer_bias += draw(kNoise.accelerometer_random_walk * std::sqrt(kTau));
      x.gyroscope_bias += draw(kNoise.gyroscope_random_walk * std::sqrt(kTau));
    }
    squares += factor.matrixL().solve(local(end, x)).cwiseAbs2();
  }
  // A mean of 3000 chi^2_1 has the standard deviation sqrt(2/3000) = 0.026; of 15 of them 0.0067.
  EXPECT_NEAR(squares.mean() / kRuns, 1, 3 * 0.0067);
  EXPECT_LT((squares / kRuns - Vector15d::Ones()).cwiseAbs().maxCoeff(), 4 * 0.026);
}

TEST(Strapdown, NoiseIsSymmetricAndPositiveSemidefinite) {
  test::Random random(12);
  for (const double tau : {1e-9, 1e-4, 0.01, 0.5}) {
    for (const double rate : {0.0, 1e-5, 20.0}) {
      const Matrix15d Q = strapdown(random_state(random), random_interval(random, tau, rate),
                                    kTiltedGravity, kNoise)
                              .Q;
      EXPECT_EQ(Q, Matrix15d(Q.transpose()));
      const Vector15d values = Eigen::SelfAdjointEigenSolver<Matrix15d>(Q).eigenvalues();
      EXPECT_GE(values.minCoeff(), -1e-15 * values.maxCoeff());
      EXPECT_GT(values.maxCoeff(), 0);
    }
  }
}

TEST(Strapdown, NoiseScaleMultipliesTheWhiteNoiseOnly) {
  test::Random random(13);
  const InertialState x = random_state(random);
  ImuInterval interval = random_interval(random, 0.1, 3);
  const Matrix15d one = strapdown(x, interval, kTiltedGravity, kNoise).Q;
  interval.noise_scale = 7;
  const Matrix15d seven = strapdown(x, interval, kTiltedGravity, kNoise).Q;
  EXPECT_TRUE(test::agree(seven.topLeftCorner<9, 9>(), 7 * one.topLeftCorner<9, 9>(), 1e-14, 0));
  EXPECT_EQ(Matrix6d(seven.bottomRightCorner<6, 6>()), Matrix6d(one.bottomRightCorner<6, 6>()));
}

TEST(Strapdown, NoTimeChangesNothing) {
  test::Random random(14);
  const InertialState x = random_state(random);
  const StrapdownStep step = strapdown(x, random_interval(random, 0, 5), kTiltedGravity, kNoise);
  EXPECT_TRUE(test::agree(local(x, step.state), Vector15d::Zero(), 1e-15));
  EXPECT_EQ(step.F, Matrix15d::Identity());
  EXPECT_EQ(step.Q, Matrix15d::Zero());
  EXPECT_TRUE(step.d_gravity.isZero(0));
}

}  // namespace
}  // namespace chasles
