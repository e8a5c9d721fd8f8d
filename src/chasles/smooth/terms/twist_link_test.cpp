#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/velocity_testing.hpp>
#include <chasles/smooth/terms/twist_link.hpp>

namespace chasles {
namespace {

using test::agree;
using test::Random;

constexpr double kTau = 0.1;

std::vector<BodyVelocityModel> models() {
  std::vector<BodyVelocityModel> all;
  for (const bool state : {true, false}) {
    for (const bool bias : {true, false}) {
      for (const bool scale : {true, false}) {
        all.push_back({.velocity_state = state, .gyro_bias = bias, .scale = scale});
        if (!state) continue;
        all.push_back(all.back());
        all.back().level = true;
      }
    }
  }
  return all;
}

VelocityState random_drive_state(Random& random, const BodyVelocityModel& model) {
  return {.world_T_imu = test::random_pose(random, 20),
          .additive = 0.5 * random.normal_vector(model.size())};
}

BodyVelocity random_velocity(Random& random) {
  return {.time = {},
          .linear_imu = 5 * random.normal_vector(3),
          .angular_imu = random.normal_vector(3)};
}

Prediction filter_step(const BodyVelocityModel& model, const VelocityState& now,
                       const BodyVelocity& held) {
  State x;
  x.world_T_imu = now.world_T_imu;
  x.additive = now.additive;
  return predict(model, x, held, kTau, test::small_drive_noise().motion);
}

// A link with zero residual gives the filter's prediction of the next state: mean, transition and
// noise.
TEST(TwistLink, IsTheFiltersPrediction) {
  Random random(1);
  for (const BodyVelocityModel& model : models()) {
    for (int trial = 0; trial < 10; ++trial) {
      const VelocityState now = random_drive_state(random, model);
      const BodyVelocity held = random_velocity(random);
      const Prediction p = filter_step(model, now, held);
      const TwistLink link = twist_link(model, kTau, held, test::small_drive_noise().motion);
      TwistDerivatives d;
      const Eigen::VectorXd r =
          twist_residual(link, now, {.world_T_imu = p.world_T_imu, .additive = p.additive}, &d);
      EXPECT_LT(r.cwiseAbs().maxCoeff(), 1e-9);
      const Eigen::MatrixXd back = d.next.inverse();
      EXPECT_TRUE(agree(Eigen::MatrixXd(-back * d.now), p.F, 1e-9));
      EXPECT_LT(test::covariance_difference(back * back.transpose(), p.Q), 1e-9);
    }
  }
}

TEST(TwistLink, WithoutWalkTheBiasesAreHeldNotSingular) {
  BodyVelocityNoise noise = test::small_drive_noise().motion;
  noise.gyro_bias_walk = noise.scale_walk = noise.tilt_walk = noise.heading_walk = 0;
  const BodyVelocityModel model{
      .velocity_state = true, .gyro_bias = true, .scale = true, .level = true};
  EXPECT_TRUE(twist_link(model, kTau, {}, noise).whitening.allFinite());
}

TEST(TwistLink, NoNoiseOrNoNumbersAreRejected) {
  BodyVelocityNoise noise = test::small_drive_noise().motion;
  noise.walk[4] = 0;
  EXPECT_THROW(twist_link({}, kTau, {}, noise), InputError);
  noise.walk[4] = std::nan("");
  EXPECT_THROW(twist_link({}, kTau, {}, noise), InputError);
  noise = test::small_drive_noise().motion;
  noise.sample_sigma[1] = 0;
  EXPECT_NO_THROW(twist_link({}, kTau, {}, noise));  // a sample is a separate measurement there
  EXPECT_THROW(twist_link({.velocity_state = false}, kTau, {}, noise), InputError);
}

}  // namespace
}  // namespace chasles
