#include <numbers>

#include <chasles/filter/testing.hpp>
#include <chasles/velocity/body_velocity_model.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<BodyVelocityModel> all_models() {
  std::vector<BodyVelocityModel> models;
  for (const bool velocity_state : {false, true}) {
    for (const bool gyro_bias : {false, true}) {
      for (const bool scale : {false, true}) {
        models.push_back(
            {.velocity_state = velocity_state, .gyro_bias = gyro_bias, .scale = scale});
        if (!velocity_state) continue;
        models.push_back(models.back());
        models.back().level = true;
      }
    }
  }
  return models;
}

std::string text(const BodyVelocityModel& model) {
  return std::string(model.velocity_state ? "velocity state" : "input") +
         (model.gyro_bias ? ", bias" : "") + (model.scale ? ", scale" : "") +
         (model.level ? ", level" : "");
}

State random_state(const BodyVelocityModel& model, test::Random& random) {
  State x = test::random_state(
      random, {.velocity = false, .additive = model.size(), .landmarks = 0, .gap = 0});
  x.additive *= 0.3;
  return x;
}

BodyVelocityNoise some_noise() {
  BodyVelocityNoise noise{.sample_sigma = {},
                          .walk = {},
                          .gyro_bias_walk = 0.02,
                          .scale_walk = 0.03,
                          .tilt_walk = 0.04,
                          .heading_walk = 0.05};
  noise.sample_sigma << 0.02, 0.03, 0.01, 0.2, 0.3, 0.1;
  noise.walk << 0.1, 0.2, 0.3, 2, 1, 0.5;
  return noise;
}

State after(const Prediction& step, State x) {
  x.world_T_imu = step.world_T_imu;
  x.additive = step.additive;
  return x;
}

TEST(BodyVelocityModel, TransitionIsTheDerivativeOfTheStep) {
  test::Random random(1);
  for (const BodyVelocityModel& model : all_models()) {
    for (const double rate : {0.0, 1e-9, 1e-4, 0.3, 8.0}) {
      SCOPED_TRACE(::testing::Message() << text(model) << ", rate " << rate);
      State x = random_state(model, random);
      const BodyVelocity u{
          .time = {}, .linear_imu = {15, 0.5, -0.3}, .angular_imu = rate * random.axis()};
      if (model.velocity_state) x.additive.head<6>() << u.angular_imu, u.linear_imu;
      const double tau = 0.2;
      const auto step = [&](const State& from) {
        return after(predict(model, from, u, tau, {}), from);
      };
      const State next = step(x);
      const auto mapped = [&](const VectorXd& e) {
        return kStandardChart.local(next, step(test::moved(kStandardChart, x, e)));
      };
      EXPECT_TRUE(test::agree(predict(model, x, u, tau, {}).F,
                              test::numeric_derivative(mapped, VectorXd::Zero(x.core_size())),
                              1e-9));
    }
  }
}

TEST(BodyVelocityModel, ConstantTurnDrivesACircle) {
  const BodyVelocityModel model{.velocity_state = false, .gyro_bias = false, .scale = false};
  const double v = 12, w = 0.7, tau = 1.3;
  const BodyVelocity u{.time = {}, .linear_imu = {v, 0, 0}, .angular_imu = {0, 0, w}};
  State x;
  x.additive.resize(0);
  const Prediction step = predict(model, x, u, tau, {});
  const Eigen::Vector3d expected(v / w * std::sin(w * tau), v / w * (1 - std::cos(w * tau)), 0);
  EXPECT_TRUE(test::agree(step.world_T_imu.p, expected, 1e-15));
  EXPECT_NEAR(so3::log(step.world_T_imu.R).z(), w * tau, 1e-15);
}

TEST(BodyVelocityModel, BiasIsTakenFromTheRateAndTheVelocityIsDividedByItsScale) {
  const BodyVelocityModel model{.velocity_state = false, .gyro_bias = true, .scale = true};
  State x;
  x.additive.resize(4);
  x.additive << 0.1, 0.2, 0.3, std::log(1.25);
  const BodyVelocity u{.time = {}, .linear_imu = {10, 5, 0}, .angular_imu = {1, 1, 1}};
  Vector6d expected;
  expected << 0.9, 0.8, 0.7, 8, 4, 0;
  EXPECT_TRUE(test::agree(corrected_velocity(model, x, u), expected, 1e-15));
}

TEST(BodyVelocityModel, SampleMovesNothingWhereTheVelocityIsAState) {
  const BodyVelocityModel model;
  test::Random random(2);
  const State x = random_state(model, random);
  const BodyVelocity u{.time = {}, .linear_imu = {10, 5, 0}, .angular_imu = {1, 1, 1}};
  EXPECT_EQ(predict(model, x, u, 0.1, {}).world_T_imu.p,
            predict(model, x, {}, 0.1, {}).world_T_imu.p);
}

// Q of the continuous model d theta' = R dw, dp' = R dv - [R v]x dtheta with white walks of (w, v),
// by Runge-Kutta steps of P' = A P + P A^T + q.
MatrixXd integrated_noise(const Vector6d& velocity, const SE3& world_T_imu, const Vector6d& walk,
                          double tau) {
  MatrixXd q = MatrixXd::Zero(12, 12);
  q.diagonal().tail<6>() = walk.cwiseAbs2();
  const auto slope = [&](double t, const MatrixXd& P) -> MatrixXd {
    const Eigen::Matrix3d R = world_T_imu.R * so3::exp(t * velocity.head<3>());
    MatrixXd A = MatrixXd::Zero(12, 12);
    A.block<3, 3>(0, 6) = R;
    A.block<3, 3>(3, 9) = R;
    A.block<3, 3>(3, 0) = -hat(R * velocity.tail<3>());
    return A * P + P * A.transpose() + q;
  };
  constexpr int kSteps = 200;
  const double h = tau / kSteps;
  MatrixXd P = MatrixXd::Zero(12, 12);
  for (int i = 0; i < kSteps; ++i) {
    const double t = i * h;
    const MatrixXd k1 = slope(t, P);
    const MatrixXd k2 = slope(t + h / 2, P + h / 2 * k1);
    const MatrixXd k3 = slope(t + h / 2, P + h / 2 * k2);
    const MatrixXd k4 = slope(t + h, P + h * k3);
    P += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return P;
}

TEST(BodyVelocityModel, WalkOfTheVelocityAtStandstillHasTheExactIntegrals) {
  const BodyVelocityModel model{.velocity_state = true, .gyro_bias = false, .scale = false};
  const BodyVelocityNoise noise = some_noise();
  test::Random random(3);
  State x = random_state(model, random);
  x.additive.setZero();
  const double tau = 0.4;
  const MatrixXd Q = predict(model, x, {}, tau, noise).Q;
  Matrix6d R = Matrix6d::Zero();
  R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = x.world_T_imu.R;
  const Matrix6d q = noise.walk.cwiseAbs2().asDiagonal();
  EXPECT_TRUE(
      test::agree(Q.topLeftCorner<6, 6>(), std::pow(tau, 3) / 3 * R * q * R.transpose(), 1e-14, 0));
  EXPECT_TRUE(test::agree(Q.topRightCorner<6, 6>(), tau * tau / 2 * R * q, 1e-14, 0));
  EXPECT_TRUE(test::agree(Q.bottomRightCorner<6, 6>(), tau * q, 1e-14, 0));
  EXPECT_TRUE(
      test::agree(Q, integrated_noise(Vector6d::Zero(), x.world_T_imu, noise.walk, tau), 1e-12, 0));
}

TEST(BodyVelocityModel, WalkOfTheVelocityOnTheMoveIsTheIntegralToFirstOrderInTheStep) {
  const BodyVelocityModel model{.velocity_state = true, .gyro_bias = false, .scale = false};
  const BodyVelocityNoise noise = some_noise();
  test::Random random(4);
  State x = random_state(model, random);
  x.additive << 0.2, -0.3, 0.6, 5, 0.4, -0.3;
  // Each entry in units of its two standard deviations: the largest difference over a step.
  const auto error = [&](double tau) {
    return test::covariance_difference(
        predict(model, x, {}, tau, noise).Q,
        integrated_noise(x.additive, x.world_T_imu, noise.walk, tau));
  };
  EXPECT_LT(error(0.02), 0.1);
  EXPECT_NEAR(error(0.02) / error(0.01), 2, 0.1);
  EXPECT_NEAR(error(0.01) / error(0.005), 2, 0.05);
}

TEST(BodyVelocityModel, NoiseOfTheInputIsWhatNoisySamplesDoToTheStep) {
  const BodyVelocityModel model{.velocity_state = false, .gyro_bias = false, .scale = true};
  BodyVelocityNoise noise = some_noise();
  noise.scale_walk = 0;
  test::Random random(5);
  State x = random_state(model, random);
  x.additive[0] = 0.2;
  const BodyVelocity u{.time = {}, .linear_imu = {8, 0.5, -0.3}, .angular_imu = {0.3, -0.4, 2}};
  const double tau = 0.5;
  const Prediction step = predict(model, x, u, tau, noise);
  const State mean = after(step, x);
  MatrixXd samples(6, 4000);
  for (auto sample : samples.colwise()) {
    const VectorXd n = noise.sample_sigma.cwiseProduct(random.normal_vector(6));
    const BodyVelocity noisy{.time = {},
                             .linear_imu = u.linear_imu + n.tail<3>(),
                             .angular_imu = u.angular_imu + n.head<3>()};
    const State moved = after(predict(model, x, noisy, tau, noise), x);
    sample = kStandardChart.local(mean, moved).head<6>();
  }
  EXPECT_TRUE(test::has_covariance(samples, step.Q.topLeftCorner<6, 6>()));
}

TEST(BodyVelocityModel, BiasScaleTiltAndHeadingWalkByThemselves) {
  const BodyVelocityNoise noise = some_noise();
  test::Random random(6);
  for (const BodyVelocityModel& model : all_models()) {
    SCOPED_TRACE(text(model));
    const State x = random_state(model, random);
    const MatrixXd Q = predict(model, x, {}, 0.3, noise).Q;
    for (int i = model.bias_index(); i < model.size(); ++i) {
      const bool scale = model.scale && i == model.scale_index();
      const bool tilt = model.level && i >= model.tilt_index();
      const bool heading = model.level && i == model.heading_index();
      const double walk = scale     ? noise.scale_walk
                          : heading ? noise.heading_walk
                          : tilt    ? noise.tilt_walk
                                    : noise.gyro_bias_walk;
      VectorXd expected = VectorXd::Zero(x.core_size());
      expected[6 + i] = 0.3 * walk * walk;
      EXPECT_TRUE(test::agree(Q.col(6 + i), expected, 1e-15, 0));
      EXPECT_TRUE(test::agree(Q.row(6 + i).transpose(), expected, 1e-15, 0));
    }
  }
}

TEST(BodyVelocityModel, MeasuredVelocityHasTheDerivativeOfItsResidual) {
  test::Random random(7);
  const BodyVelocity u{.time = {}, .linear_imu = {9, 1, 2}, .angular_imu = {0.1, 0.2, 0.3}};
  for (const BodyVelocityModel& model : all_models()) {
    if (!model.velocity_state) continue;
    SCOPED_TRACE(text(model));
    const State x = random_state(model, random);
    const Measurement z = measure_velocity(model, x, u, some_noise());
    const auto residual = [&](const VectorXd& e) -> VectorXd {
      return measure_velocity(model, test::moved(kStandardChart, x, e), u, {}).residual;
    };
    MatrixXd H = MatrixXd::Zero(6, x.core_size());
    H.middleCols(z.core_column, z.d_core.cols()) = z.d_core;
    EXPECT_TRUE(
        test::agree(-H, test::numeric_derivative(residual, VectorXd::Zero(x.core_size())), 1e-9));
    EXPECT_TRUE(test::agree(z.noise.diagonal(), some_noise().sample_sigma.cwiseAbs2(), 1e-15, 0));
    EXPECT_LT(z.landmark, 0);
  }
}

TEST(BodyVelocityModel, MeasuredVelocityIsTheTrueOneTimesItsScaleWithTheBiasOnTop) {
  const BodyVelocityModel model{.velocity_state = true, .gyro_bias = true, .scale = true};
  State x;
  x.additive.resize(10);
  x.additive << 1, 2, 3, 10, 20, 30, 0.1, 0.2, 0.3, std::log(1.1);
  const BodyVelocity u{.time = {}, .linear_imu = {11, 22, 33}, .angular_imu = {1.1, 2.2, 3.3}};
  EXPECT_LT(measure_velocity(model, x, u, some_noise()).residual.norm(), 1e-14);
}

TEST(BodyVelocityModel, LevelSampleOfACarOnASlopeClimbsAndTurnsAboutTheVertical) {
  const BodyVelocityModel model{
      .velocity_state = true, .gyro_bias = false, .scale = false, .level = true};
  const double pitch = 0.2, roll = -0.1, tilt = 0.05, heading = 0.03;
  const auto about = [](double angle, const Eigen::Vector3d& axis) {
    return so3::exp(angle * axis);
  };
  State x;
  x.additive = VectorXd::Zero(9);
  x.additive[model.tilt_index()] = tilt;
  x.additive[model.heading_index()] = heading;
  // In nav the heading of the car is 1.2 rad, nose up; the world is nav tilted by -tilt about x.
  const Eigen::Matrix3d heads = about(1.2, Eigen::Vector3d::UnitZ());
  x.world_T_imu.R = about(-tilt, Eigen::Vector3d::UnitX()) * heads *
                    about(-pitch, Eigen::Vector3d::UnitY()) * about(roll, Eigen::Vector3d::UnitX());
  x.additive.head<3>() = x.world_T_imu.R.transpose() *
                         (about(-tilt, Eigen::Vector3d::UnitX()) * Eigen::Vector3d(0, 0, 0.4));
  x.additive[3] = 10;
  const BodyVelocity u{.time = {},
                       .linear_imu = about(heading, Eigen::Vector3d::UnitZ()) *
                                     Eigen::Vector3d(10 * std::cos(pitch), 0, 10 * std::sin(pitch)),
                       .angular_imu = {0, 0, 0.4}};
  EXPECT_LT(measure_velocity(model, x, u, some_noise()).residual.norm(), 1e-14);
}

TEST(BodyVelocityModel, LevelSampleOfABodyThatLooksUpIsRejectedByTheUpdate) {
  const BodyVelocityModel model{
      .velocity_state = true, .gyro_bias = false, .scale = false, .level = true};
  State x;
  x.additive = VectorXd::Zero(9);
  x.world_T_imu.R = so3::exp(Eigen::Vector3d(0, -std::numbers::pi / 2, 0));
  const Measurement z[] = {measure_velocity(model, x, {}, some_noise())};
  EXPECT_TRUE(z[0].residual.hasNaN());
  Ekf ekf(kStandardChart, x, MatrixXd::Identity(15, 15), {});
  const UpdateReport report = ekf.update(z);
  EXPECT_EQ(report.dof, 0);
  EXPECT_EQ(ekf.covariance(), MatrixXd::Identity(15, 15));
}

}  // namespace
}  // namespace chasles
