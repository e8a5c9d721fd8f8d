#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/zero_velocity_updater.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Samples without noise and forty tracks, all at a standstill. Returns the frame at each 0.05 s.
FeatureFrame still(ZeroVelocityUpdater& updater, int number) {
  const double t = 0.05 * number;
  for (int i = 0; i < 10; ++i) {
    updater.add({.time = from_seconds(t - 0.05 + 0.005 * (i + 1)),
                 .specific_force_imu = {0.3, 0.1, 9.8},
                 .angular_rate_imu = Eigen::Vector3d::Zero()});
  }
  FeatureFrame frame{.time = from_seconds(t)};
  for (int k = 0; k < 40; ++k) {
    frame.pixels.push_back({.landmark = k, .pixel = {100.0 + 10 * k, 50.0 + 7 * k}});
  }
  return frame;
}

// Standstill before the update: the first frame of it becomes a clone.
struct Standing {
  explicit Standing(double sigma, std::uint64_t seed)
      : random(seed),
        x(test::some_context(random)),
        updater(settings(sigma), test::imu_noise(), 1, 1) {
    x.settings.zupt_velocity_sigma = sigma;
  }
  static InertialSlamSettings settings(double sigma) {
    InertialSlamSettings s;
    s.zupt_velocity_sigma = sigma;
    return s;
  }
  bool step() {
    ++x.frame;
    const FeatureFrame frame = still(updater, ++number);
    return updater.update(x, frame, from_seconds(0.05));
  }

  test::Random random;
  SlamContext x;
  ZeroVelocityUpdater updater;
  int number = 0;
};

// The pose is that of the clone and the velocity zero, with numeric derivatives of both residuals.
TEST(ZeroVelocityUpdater, IsTheKalmanUpdateWithNumericDerivatives) {
  constexpr double kSigma = 0.3;
  Standing standing(kSigma, 1);
  SlamContext& x = standing.x;
  while (!standing.updater.clone()) {
    ASSERT_FALSE(standing.step());
    ASSERT_LT(standing.number, 40);
  }
  const int clone = *standing.updater.clone();
  EXPECT_EQ(clone, x.frame);
  const auto residuals = [&](const VectorXd& e) -> VectorXd {
    const State y = test::moved(kStandardChart, x.state(), e);
    const SE3& then = y.clone(clone).world_T_imu;
    VectorXd r(9);
    r << -so3::log(y.world_T_imu.R * then.R.transpose()), then.p - y.world_T_imu.p, -*y.v_world;
    return r;
  };
  const VectorXd zero = VectorXd::Zero(x.state().size());
  const MatrixXd H = -test::numeric_derivative(residuals, zero);
  VectorXd variances(9);  // of one second: 1 mrad, 5 mm and the setting
  variances << VectorXd::Constant(3, 1e-6), VectorXd::Constant(3, 25e-6),
      VectorXd::Constant(3, kSigma * kSigma);
  const MatrixXd R = (variances / 0.05).asDiagonal();
  const auto expected = test::updated(x.state(), x.filter.covariance(), H, R, residuals(zero));
  EXPECT_TRUE(standing.step());
  test::expect_updated(x.filter, expected);
}

TEST(ZeroVelocityUpdater, IsOffWithoutASigma) {
  Standing standing(0, 2);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(standing.step());
  EXPECT_FALSE(standing.updater.clone());
}

TEST(ZeroVelocityUpdater, AStandstillThatTheStateContradictsIsRejected) {
  Standing standing(0.01, 3);
  standing.x.settings.gate = 0.999;  // v_world is some m/s, with a sigma of centimetres
  const State before = standing.x.state();
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(standing.step());
  EXPECT_TRUE(standing.updater.clone());
  EXPECT_EQ((*standing.x.state().v_world - *before.v_world).norm(), 0);
}

}  // namespace
}  // namespace chasles
