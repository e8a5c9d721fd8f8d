#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/reconstruct/predicted_path.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;

// A level circle at 1 m/s and 0.5 rad/s, with an accelerometer and a gyroscope that have biases:
// 200 Hz, with a state every 100 ms.
class Circle : public ::testing::Test {
 public:
  Circle() {
    recording.name = "circle";
    recording.cameras.resize(1);
    recording.imu_noise = ImuNoise{.accelerometer_noise_density = 1e-3,
                                   .accelerometer_random_walk = 1e-4,
                                   .gyroscope_noise_density = 1e-4,
                                   .gyroscope_random_walk = 1e-5,
                                   .exact = true};
    for (int i = 0; i <= 200; ++i) {
      recording.imu.push_back({.time = milliseconds(5 * i),
                               .specific_force_imu = Vector3d(0.1, kRate + 0.2, kStandardGravity),
                               .angular_rate_imu = Vector3d(0.01, 0, kRate)});
    }
    for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
      for (const char* axis : {"_x", "_y", "_z"}) run.extra_names.push_back(std::string(of) + axis);
    }
    for (int i = 0; i <= 10; ++i) {
      RunState& state = run.states.emplace_back();
      state.time = milliseconds(100 * i);
      state.world_T_imu = pose(0.1 * i);
      state.pose_covariance = 1e-4 * Matrix6d::Identity();
      const Vector3d v = state.world_T_imu.R.col(0);
      state.extra = {v.x(), v.y(), v.z(), 0.1, 0.2, 0, 0.01, 0, 0};
      state.extra_sigma.assign(9, 0.01);
      state.health = "ok";
    }
  }

  static SE3 pose(double t) {
    return {so3::exp({0, 0, kRate * t}),
            {std::sin(kRate * t) / kRate, (1 - std::cos(kRate * t)) / kRate, 0}};
  }

  PredictedPath predicted() const { return predicted_path(run, recording, {}); }
  std::string message() const {
    try {
      predicted();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  static constexpr double kRate = 0.5;
  Recording recording;
  chasles::Run run;
};

TEST_F(Circle, AtEachSampleIsTheMotionThatTheImuMeasured) {
  const PredictedPath path = predicted();
  ASSERT_EQ(path.run.states.size(), 201);
  EXPECT_EQ(path.without, 0);
  for (const RunState& state : path.run.states) {
    const SE3 expected = pose(to_seconds(state.time));
    EXPECT_LT((state.world_T_imu.p - expected.p).norm(), 1e-6);
    EXPECT_LT((state.world_T_imu.R - expected.R).norm(), 1e-6);
    EXPECT_NEAR(state.extra[0], expected.R(0, 0), 1e-5);
  }
  // The uncertainty grows from a state to the next one.
  EXPECT_LT(path.run.states[20].pose_covariance(3, 3), path.run.states[30].pose_covariance(3, 3));
  EXPECT_LT(path.run.states[20].pose_covariance(3, 3), path.run.states[39].pose_covariance(3, 3));
  EXPECT_NEAR(path.run.states[40].pose_covariance(3, 3), 1e-4, 1e-12);
}

TEST_F(Circle, AStateCorrectsThePathOnlyFromItsTimeOn) {
  for (std::size_t i = 5; i < run.states.size(); ++i) run.states[i].world_T_imu.p.z() = 1;
  const PredictedPath path = predicted();
  EXPECT_NEAR(path.run.states[99].world_T_imu.p.z(), 0, 1e-9);
  EXPECT_NEAR(path.run.states[100].world_T_imu.p.z(), 1, 1e-9);
}

TEST_F(Circle, WhereTheRunIsLostThereIsNoState) {
  run.states[5].health = "lost";
  const PredictedPath path = predicted();
  EXPECT_EQ(path.run.states.size(), 181);
  EXPECT_EQ(path.without, 20);
}

TEST_F(Circle, WhatCannotBePredictedIsSaid) {
  const auto names = run.extra_names;
  run.extra_names.clear();
  EXPECT_NE(message().find("has no velocities and biases"), std::string::npos);
  run.extra_names = names;
  run.extra_names.push_back("accelerometer_scale_x");
  EXPECT_NE(message().find("expected a run without calibrate_imu"), std::string::npos);
  run.extra_names = names;
  recording.imu.clear();
  EXPECT_NE(message().find("recording 'circle' has no IMU samples"), std::string::npos);
}

}  // namespace
}  // namespace chasles
