#include <gtest/gtest.h>

#include <chasles/robot/state_stream.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

struct CountingSink : StateSink {
  void odometry(const BodyState&, Time) override { ++odometries; }
  void map_T_odom(const SE3&, Time) override { ++places; }
  void points(std::span<const MapLandmark>, Time) override { ++clouds; }
  void quality(Health health, std::size_t jumps) override {
    ++qualities;
    last_health = health;
    last_jumps = jumps;
  }
  int qualities = 0;
  Health last_health = Health::kLost;
  std::size_t last_jumps = 7;
  int odometries = 0, places = 0, clouds = 0;
};

Estimate estimate_at(Time time) {
  Estimate e;
  e.time = time;
  e.v_world = Eigen::Vector3d::Zero();
  e.additive = Vector6d::Zero();
  e.covariance = Matrix15d::Identity();
  e.in_map.emplace();
  return e;
}

TEST(StateStream, SendsNothingOfAnEstimateThatIsLost) {
  const Recording recording = simulate_inertial(inertial_scene("hallway"), 0);
  VisualInertialSlam slam(recording.cameras, *recording.imu_noise);
  CountingSink sink;
  StateStream stream({}, sink);
  Estimate e = estimate_at(std::chrono::seconds(1));
  stream.take(std::span(&e, 1), slam);
  EXPECT_EQ(sink.places, 1);
  EXPECT_EQ(sink.clouds, 1);
  e.time += std::chrono::seconds(2);
  e.health = Health::kLost;
  stream.take(std::span(&e, 1), slam);
  EXPECT_EQ(sink.places, 1);
  EXPECT_EQ(sink.clouds, 1);
  EXPECT_EQ(sink.odometries, 0);  // the estimator has none
  EXPECT_TRUE(stream.any());
}

TEST(StateStream, TheQualityIsForASinkThatWantsIt) {
  const Recording recording = simulate_inertial(inertial_scene("hallway"), 0);
  VisualInertialSlam slam(recording.cameras, *recording.imu_noise);
  CountingSink sink;
  Estimate e = estimate_at(std::chrono::seconds(1));
  e.health = Health::kDegraded;
  StateStream({}, sink).take(std::span(&e, 1), slam);
  EXPECT_EQ(sink.qualities, 0);
  StateStream({.jumps = true}, sink).take(std::span(&e, 1), slam);
  EXPECT_EQ(sink.qualities, 1);
  EXPECT_EQ(sink.last_health, Health::kDegraded);
  EXPECT_EQ(sink.last_jumps, 0);
}

}  // namespace
}  // namespace chasles
