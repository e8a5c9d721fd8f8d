#include <gtest/gtest.h>

#include <chasles/sim/inertial_sim.hpp>

#include "stamp_check.hpp"
#include "state_stream.hpp"

namespace chasles::bridge {
namespace {

struct CountingSink : StateSink {
  void odometry(const BodyState&, Time) override { ++odometries; }
  void map_T_odom(const SE3&, Time) override { ++places; }
  void points(std::span<const MapLandmark>, Time) override { ++clouds; }
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

TEST(StampCheck, CountsMessagesWithoutAStamp) {
  StampCheck check;
  EXPECT_TRUE(check.is_set(Time(1), "/imu0"));
  EXPECT_FALSE(check.is_set(Time(0), "/imu0"));
  EXPECT_FALSE(check.is_set(Time(0), "/imu0"));
  EXPECT_EQ(check.unset(), 2u);
}

}  // namespace
}  // namespace chasles::bridge
