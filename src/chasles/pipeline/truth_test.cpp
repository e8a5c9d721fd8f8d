#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

TEST(Truth, BetweenTwoStampsTheMotionIsOnAStraightLine) {
  Recording recording;
  recording.true_motion = {{.time = from_seconds(1), .v_world = {1, 0, 0}},
                           {.time = from_seconds(1.1), .v_world = {2, 4, 0}},
                           {.time = from_seconds(1.4), .v_world = {0, 0, 0}}};
  recording.true_motion[1].accelerometer_bias = {0.4, 0, 0};
  recording.true_motion[1].gyroscope_bias = {0, 0.8, 0};
  const auto between = true_motion_at(recording, from_seconds(1.025));
  ASSERT_TRUE(between);
  EXPECT_LT((between->v_world - Eigen::Vector3d(1.25, 1, 0)).norm(), 1e-12);
  EXPECT_LT((between->accelerometer_bias - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((between->gyroscope_bias - Eigen::Vector3d(0, 0.2, 0)).norm(), 1e-12);
  EXPECT_EQ(true_motion_at(recording, from_seconds(1.1))->v_world, Eigen::Vector3d(2, 4, 0));
  EXPECT_FALSE(true_motion_at(recording, from_seconds(1.2))) << "the gap is too long";
  recording.pairing.longest_gap = from_seconds(0.3);
  EXPECT_TRUE(true_motion_at(recording, from_seconds(1.2)));
  EXPECT_FALSE(true_motion_at(recording, from_seconds(0.9)));
  EXPECT_FALSE(true_motion_at(recording, from_seconds(1.5)));
}

TEST(TrueStart, TakesTheVelocityFromThePosesWhereNoneIsRecorded) {
  Recording recording = simulate_inertial(test::short_hallway());
  const Eigen::Vector3d v = recording.true_motion.front().v_world;
  EXPECT_EQ(true_start(recording).v_nav, v);
  EXPECT_GT(v.norm(), 0.5);
  recording.true_motion.clear();
  EXPECT_LT((true_start(recording).v_nav - v).norm(), 0.02);
}

TEST(TrueStart, IsTheFirstFrameWithTruth) {
  Recording recording = simulate_inertial(test::short_hallway());
  recording.truth.erase(recording.truth.begin(), recording.truth.begin() + 40);
  const InertialStart start = true_start(recording);
  EXPECT_EQ(start.time, recording.frames[40].time);
  EXPECT_EQ(start.nav_T_imu.p, recording.truth.front().pose.p);
}

TEST(TrueStart, NeedsATruthAtTheTimeOfAFrame) {
  Recording recording = simulate_inertial(test::short_hallway());
  const Trajectory truth = std::exchange(recording.truth, {});
  const auto rejection = [&] {
    try {
      true_start(recording);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(rejection().find("has no truth"), std::string::npos) << rejection();
  recording.truth = {truth.back()};
  recording.truth.front().time += from_seconds(10);
  EXPECT_NE(rejection().find("has no frame at whose time its truth is known"), std::string::npos)
      << rejection();
}

// Errors of the covariance's own distribution, in each chart: 15 on average.
TEST(StateNees, OfErrorsThatAreAsTheCovarianceStatesIsChiSquared) {
  const Recording recording = simulate_inertial(test::short_hallway());
  const TrueMotion& truth = recording.true_motion[50];
  const SE3 pose = *pose_at(recording.truth, truth.time);
  Eigen::Matrix<double, 15, 1> sigma;
  sigma << 1e-3, 2e-3, 3e-3, 0.01, 0.02, 0.03, 0.02, 0.02, 0.02, 0.1, 0.1, 0.1, 0.01, 0.01, 0.01;
  const Random random{.seed = 3};
  constexpr int kDraws = 300;
  for (const char* chart : {"standard", "left-se3", "right-se3", "right-sen3"}) {
    double sum = 0;
    for (std::uint64_t k = 0; k < kDraws; ++k) {
      Eigen::Matrix<double, 15, 1> d;
      for (std::uint32_t i = 0; i < 15; ++i) d[i] = sigma[i] * random.normal(Stream::kStart, k, i);
      Estimate e;
      e.time = truth.time;
      e.world_T_imu = {so3::exp(Eigen::Vector3d(-d.head<3>())) * pose.R, pose.p - d.segment<3>(3)};
      e.v_world = truth.v_world - d.segment<3>(6);
      e.additive.resize(6);
      e.additive << truth.accelerometer_bias - d.segment<3>(9),
          truth.gyroscope_bias - d.segment<3>(12);
      e.covariance = sigma.cwiseAbs2().asDiagonal();
      sum += state_nees(chart, recording, e);
    }
    EXPECT_TRUE(chi2_band(15, kDraws, 0.999).contains(sum / kDraws))
        << chart << ' ' << sum / kDraws;
  }
  Estimate elsewhere;
  elsewhere.time = truth.time + Time(1);
  elsewhere.v_world.emplace();
  EXPECT_TRUE(std::isnan(state_nees("standard", recording, elsewhere)));
}

}  // namespace
}  // namespace chasles
