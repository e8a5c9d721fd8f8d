#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/mps.hpp>

namespace chasles {
namespace {

// A table by its columns, which the reader finds by their names.
class Columns {
 public:
  explicit Columns(const std::string& text) {
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    std::vector<std::string> names;
    for (std::istringstream words(line); std::getline(words, line, ',');) names.push_back(line);
    while (std::getline(lines, line)) {
      std::istringstream words(line);
      auto& row = rows_.emplace_back();
      for (const std::string& name : names) std::getline(words, row[name], ',');
    }
  }
  std::size_t size() const { return rows_.size(); }
  const std::string& text(std::size_t i, const std::string& name) const {
    return rows_.at(i).at(name);
  }
  double number(std::size_t i, const std::string& name) const { return std::stod(text(i, name)); }
  Eigen::Vector3d vector(std::size_t i, const std::string& before, const std::string& after) const {
    return {number(i, before + "x" + after), number(i, before + "y" + after),
            number(i, before + "z" + after)};
  }

 private:
  std::vector<std::map<std::string, std::string>> rows_;
};

// 2 m/s forward while the IMU turns by 0.5 rad/s about its z axis.
ReportRun turning_run() {
  ReportRun turning;
  Run& run = turning.run;
  turning.summary = R"({"settings": {"start.gravity": 9.7}})";
  run.name = "turning";
  run.extra_names = {"velocity_x", "velocity_y", "velocity_z", "accelerometer_bias_x"};
  for (int k = 0; k < 20; ++k) {
    RunState s;
    s.time = std::chrono::milliseconds(100 * k) + Time(1'234'567);
    s.world_T_imu = {so3::exp({0, 0, 0.05 * k}), {0.01 * k, 2, 3}};
    const Eigen::Vector3d v = s.world_T_imu.R * Eigen::Vector3d(2, 0, 0);
    s.extra = {v.x(), v.y(), v.z(), 0.1};
    s.extra_sigma.assign(4, 1);
    s.health = k == 3 ? "degraded" : k == 4 ? "lost" : "ok";
    run.states.push_back(s);
    run.smoothed.push_back({.time = s.time, .world_T_imu = s.world_T_imu});
  }
  // Straight ahead of the first state, with a sigma of 0.3 m along that ray.
  run.landmarks.resize(2);
  for (RunLandmark& l : run.landmarks) {
    l.id = -7;
    l.p_world = run.states[0].world_T_imu.p + Eigen::Vector3d(0, 0, 2);
    l.covariance = Eigen::Vector3d(4, 5, 0.09).asDiagonal();
    l.first_seen = l.last_seen = run.states[0].time;
  }
  run.landmarks[0].p_world.x() = std::nan("");
  return turning;
}

TEST(Mps, AWorldADeviceAndGravity) {
  const ReportRun turning = turning_run();
  const Columns table(run_mps(turning, RunPath::kStates).trajectory);
  ASSERT_EQ(table.size(), turning.run.states.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    const SE3& T = turning.run.states[i].world_T_imu;
    EXPECT_EQ(table.vector(i, "t", "_world_device"), T.p);
    const Eigen::Quaterniond q(
        table.number(i, "qw_world_device"), table.number(i, "qx_world_device"),
        table.number(i, "qy_world_device"), table.number(i, "qz_world_device"));
    EXPECT_LT((q.toRotationMatrix() - T.R).norm(), 1e-12);
    EXPECT_EQ(table.text(i, "tracking_timestamp_us"), std::to_string(1234 + 100'000 * i));
    EXPECT_EQ(table.text(i, "utc_timestamp_ns"), "-1");
    EXPECT_EQ(table.vector(i, "gravity_", "_world"), Eigen::Vector3d(0, 0, -9.7));
    // In the axes of the device, whatever its heading.
    EXPECT_LT(
        (table.vector(i, "device_linear_velocity_", "_device") - Eigen::Vector3d(2, 0, 0)).norm(),
        1e-12);
    EXPECT_LT((table.vector(i, "angular_velocity_", "_device") - Eigen::Vector3d(0, 0, 0.5)).norm(),
              1e-9);
  }
  EXPECT_EQ(table.number(2, "quality_score"), 1);
  EXPECT_EQ(table.number(3, "quality_score"), 0.5);
  EXPECT_EQ(table.number(4, "quality_score"), 0);
}

// The smoothed path has no velocity of its own: 0.1 m/s along the x axis of the world.
TEST(Mps, TheVelocityOfTheSmoothedPathIsThatOfItsPositions) {
  const ReportRun turning = turning_run();
  const Columns table(run_mps(turning, RunPath::kSmoothed).trajectory);
  ASSERT_EQ(table.size(), turning.run.smoothed.size());
  const Eigen::Vector3d expected =
      turning.run.smoothed[9].world_T_imu.R.transpose() * Eigen::Vector3d(0.1, 0, 0);
  EXPECT_LT((table.vector(9, "device_linear_velocity_", "_device") - expected).norm(), 1e-9);
  EXPECT_EQ(table.number(4, "quality_score"), 0) << "the health is that of the state";
}

TEST(Mps, PointsHaveTheirSigmaAlongTheRay) {
  const ReportRun turning = turning_run();
  const MpsFiles files = run_mps(turning, RunPath::kStates);
  const Columns points(gunzip(files.points, "points"));
  ASSERT_EQ(points.size(), 1) << "the other one is not finite";
  EXPECT_EQ(points.text(0, "uid"), "1") << "the reader rejects negative numbers";
  EXPECT_EQ(points.vector(0, "p", "_world"), turning.run.landmarks[1].p_world);
  EXPECT_NEAR(points.number(0, "dist_std"), 0.3, 1e-12);
  EXPECT_NEAR(points.number(0, "inv_dist_std"), 0.3 / 4, 1e-12);
  const Columns table(files.trajectory);
  EXPECT_EQ(points.text(0, "graph_uid"), table.text(0, "graph_uid")) << "one world";
  EXPECT_EQ(run_mps(turning, RunPath::kSmoothed).points, files.points) << "the same bytes";
  ReportRun other = turning_run();
  other.run.states[1].world_T_imu.p.x() += 1e-9;
  const Columns another(run_mps(other, RunPath::kStates).trajectory);
  EXPECT_NE(another.text(0, "graph_uid"), table.text(0, "graph_uid")) << "another run's";
}

// One number that is not finite would empty the whole list of the reader.
TEST(Mps, WhatIsNotFiniteIsLeftOut) {
  ReportRun turning = turning_run();
  turning.run.states[5].extra[1] = std::nan("");
  turning.run.states[7].world_T_imu.p.x() = std::nan("");
  turning.run.landmarks[1].covariance(0, 0) = std::nan("");
  const MpsFiles files = run_mps(turning, RunPath::kStates);
  EXPECT_EQ(Columns(files.trajectory).size(), turning.run.states.size() - 2);
  EXPECT_EQ(files.trajectory.find("nan"), std::string::npos);
  EXPECT_EQ(Columns(gunzip(files.points, "points")).size(), 0);
}

TEST(Mps, ARunWithoutGravityOrWithOnePoseIsAnError) {
  const auto message = [](const ReportRun& run) -> std::string {
    try {
      run_mps(run, RunPath::kStates);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  ReportRun turning = turning_run();
  turning.run.states.resize(1);
  EXPECT_NE(message(turning).find("expected at least two"), std::string::npos);
  turning = turning_run();
  turning.run.extra_names.pop_back();
  for (RunState& s : turning.run.states) s.extra.pop_back();
  EXPECT_NE(message(turning).find("does not know gravity"), std::string::npos);
}

}  // namespace
}  // namespace chasles
