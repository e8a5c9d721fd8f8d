#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/viewers/mavlink.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::chrono::milliseconds;

// A level run that moves along its x axis at 2 m/s and turns left at 0.5 rad/s.
ReportRun turning_run(std::size_t count) {
  ReportRun report;
  Run& run = report.run;
  for (const char* of : {"velocity", "accelerometer_bias", "gyroscope_bias"}) {
    for (const char* axis : {"_x", "_y", "_z"}) run.extra_names.push_back(std::string(of) + axis);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    RunState& state = run.states.emplace_back();
    state.time = milliseconds(1000 + 100 * i);
    state.world_T_imu = {so3::exp({0, 0, 0.5 * t}), {2 * t, 1, 3}};
    state.pose_covariance.diagonal() << 1e-4, 2e-4, 3e-4, 0.01, 0.02, 0.03;
    state.pose_covariance(0, 4) = state.pose_covariance(4, 0) = 5e-4;
    state.extra = {2, 0.5, 0.25, 0, 0, 0, 0, 0, 0};
    state.extra_sigma = {0.1, 0.2, 0.3, 0, 0, 0, 0, 0, 0};
    state.health = "ok";
  }
  return report;
}

std::string message_of(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(FrdOdometry, ForwardIsXRightIsMinusYAndDownIsMinusZ) {
  const ReportRun run = turning_run(5);
  const auto states = frd_odometry(run, RunPath::kStates, frd_R_imu("x,-y,-z"));
  ASSERT_EQ(states.size(), 5);
  const FrdOdometry& o = states[2];
  EXPECT_LT((o.local_T_body.p - Vector3d(0.4, -1, -3)).norm(), 1e-12);
  // A left turn is a negative one about the axis down.
  EXPECT_LT((o.local_T_body.R - so3::exp({0, 0, -0.1})).norm(), 1e-12);
  EXPECT_LT((o.rate_body - Vector3d(0, 0, -0.5)).norm(), 1e-12);
  EXPECT_LT((o.v_body - so3::exp({0, 0, 0.1}) * Vector3d(2, -0.5, -0.25)).norm(), 1e-12);
}

TEST(FrdOdometry, AnImuMayBeMountedOtherwise) {
  // As in EuRoC's vehicles: x up, y right, z forward... and z of the IMU is forward.
  const Matrix3d body_R_imu = frd_R_imu("z,y,-x");
  EXPECT_EQ(body_R_imu * Vector3d::UnitZ(), Vector3d::UnitX());
  EXPECT_EQ(body_R_imu * Vector3d::UnitX(), -Vector3d::UnitZ());
  ReportRun run = turning_run(3);
  // The IMU's axes in a world where the vehicle flies level along x.
  Matrix3d world_R_imu;
  world_R_imu << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  for (RunState& s : run.run.states) s.world_T_imu.R = world_R_imu;
  const auto states = frd_odometry(run, RunPath::kStates, body_R_imu);
  EXPECT_LT((states[1].local_T_body.R - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((states[1].v_body - Vector3d(2, -0.5, -0.25)).norm(), 1e-12);
}

TEST(FrdOdometry, TheAxesOfABodyAreARotation) {
  for (const char* text : {"x,y,-z", "x,x,y", "x,-y", "x,-y,-z,", "", "a,b,c", "x,-y,-zz", ",,"}) {
    EXPECT_NE(message_of([&] { frd_R_imu(text); }).find("--body: found '" + std::string(text)),
              std::string::npos)
        << text;
  }
  EXPECT_EQ(frd_R_imu("+x,-y,-z"), frd_R_imu("x,-y,-z"));
}

// By a sample of the error on either side, in the convention of states.csv.
TEST(FrdOdometry, CovariancesAreOfPositionAlongLocalAxesAndRotationAboutTheBodys) {
  ReportRun run = turning_run(3);
  const Matrix3d body_R_imu = frd_R_imu("z,y,-x");
  const auto at = [&](const Vector6d& error) {
    ReportRun moved = run;
    SE3& pose = moved.run.states[1].world_T_imu;
    pose = {so3::exp(error.head<3>()) * pose.R, pose.p + error.tail<3>()};
    return frd_odometry(moved, RunPath::kStates, body_R_imu)[1].local_T_body;
  };
  const SE3 estimate = at(Vector6d::Zero());
  Matrix6d J;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const SE3 moved = at(kStep * Vector6d::Unit(k));
    J.col(k) << (moved.p - estimate.p) / kStep, so3::log(estimate.R.transpose() * moved.R) / kStep;
  }
  const FrdOdometry o = frd_odometry(run, RunPath::kStates, body_R_imu)[1];
  const Matrix6d expected = J * run.run.states[1].pose_covariance * J.transpose();
  EXPECT_LT((o.pose_covariance - expected).norm(), 1e-5 * expected.norm());
  const Matrix3d R = body_R_imu * run.run.states[1].world_T_imu.R.transpose();
  const Matrix3d velocity = R * Vector3d(0.01, 0.04, 0.09).asDiagonal() * R.transpose();
  EXPECT_LT((o.velocity_covariance.value() - velocity).norm(), 1e-12);
}

TEST(FrdOdometry, ALossAndALoopClosureAreResets) {
  ReportRun run = turning_run(8);
  run.run.states[2].health = run.run.states[3].health = "lost";
  run.run.states[4].health = "degraded";
  run.summary = R"({"closures": [{"time_ns": 1600000000, "landmarks": 9, "moved_m": 0.1}]})";
  const auto states = frd_odometry(run, RunPath::kStates, frd_R_imu("x,-y,-z"));
  std::vector<int> resets;
  for (const FrdOdometry& o : states) resets.push_back(o.resets);
  EXPECT_EQ(resets, (std::vector{0, 0, 0, 0, 1, 1, 2, 2}));
  EXPECT_EQ(states[3].health, "lost");
}

TEST(FrdOdometry, TheSmoothedPathHasNoSigmasOfItsVelocities) {
  ReportRun run = turning_run(4);
  for (const RunState& s : run.run.states) {
    run.run.smoothed.push_back({.time = s.time, .world_T_imu = s.world_T_imu});
  }
  const auto states = frd_odometry(run, RunPath::kSmoothed, frd_R_imu("x,-y,-z"));
  EXPECT_FALSE(states[1].velocity_covariance);
  EXPECT_LT((states[1].v_body - so3::exp({0, 0, 0.05}) * Vector3d(2, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(states[1].resets, 0);
}

TEST(FrdOdometry, WhatIsNotLevelOrDoesNotMoveIsAnError) {
  const Matrix3d axes = frd_R_imu("x,-y,-z");
  ReportRun run = turning_run(1);
  EXPECT_NE(message_of([&] { frd_odometry(run, RunPath::kStates, axes); }).find("has one pose"),
            std::string::npos);
  run.run.extra_names.clear();
  EXPECT_NE(message_of([&] {
              frd_odometry(run, RunPath::kStates, axes);
            }).find("does not know which way is down"),
            std::string::npos);
}

// The accumulation that the protocol's guide describes, byte by byte.
std::uint16_t accumulated(const std::string& bytes) {
  std::uint16_t crc = 0xffff;
  for (const char c : bytes) {
    auto t = static_cast<std::uint8_t>(static_cast<std::uint8_t>(c) ^ (crc & 0xff));
    t = static_cast<std::uint8_t>(t ^ t << 4);
    crc = static_cast<std::uint16_t>(crc >> 8 ^ t << 8 ^ t << 3 ^ t >> 4);
  }
  return crc;
}

TEST(Mavlink, AMessageHasItsStampItsFrameAndItsCheckSum) {
  const auto states = frd_odometry(turning_run(2), RunPath::kStates, frd_R_imu("x,-y,-z"));
  const std::string log = mavlink_log(states);
  constexpr std::size_t kPayload = 233, kHeader = 10, kEach = 8 + kHeader + kPayload + 2;
  ASSERT_EQ(log.size(), 2 * kEach);
  // 1.1 s as big-endian microseconds.
  EXPECT_EQ(log.substr(kEach, 8), std::string("\0\0\0\0\0\x10\xc8\xe0", 8));
  const std::string frame = log.substr(kEach + 8, kEach - 8);
  EXPECT_EQ(frame.substr(0, kHeader), std::string("\xfd\xe9\0\0\1\1\xc5\x4b\1\0", kHeader));
  std::uint16_t crc = 0;
  std::memcpy(&crc, &frame[kHeader + kPayload], 2);
  EXPECT_EQ(crc, accumulated(frame.substr(1, kHeader - 1 + kPayload) + '\x5b'));
  float x = 0;
  std::memcpy(&x, &frame[kHeader + 8], 4);
  EXPECT_EQ(x, 0.2F);
}

TEST(Mavlink, ALostStateHasFailed) {
  FrdOdometry state{.time = milliseconds(5), .health = "lost"};
  constexpr std::size_t kQuality = 8 + 10 + 232;
  EXPECT_EQ(mavlink_log(std::vector{state}).at(kQuality), -1);
  state.health = "degraded";
  EXPECT_EQ(mavlink_log(std::vector{state}).at(kQuality), 50);
  // Unknown is zero, and zeros at the end of a payload are cut.
  state.health = "";
  EXPECT_EQ(mavlink_log(std::vector{state}).at(8 + 1), static_cast<char>(232));
}

}  // namespace
}  // namespace chasles
