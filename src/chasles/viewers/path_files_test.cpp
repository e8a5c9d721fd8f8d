#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/path_files.hpp>
#include <chasles/viewers/umi.hpp>

namespace chasles {
namespace {

// A camera that looks ahead along the IMU's x axis, with its right along -y: no axis keeps its
// name, so that a wrong frame shows.
constexpr const char* kForwardCamera =
    R"({"settings": {"time_offset": "auto"}, "cameras": [{"imu_T_cam":
       [[0,0,1,0.5],[-1,0,0,-0.2],[0,-1,0,0.1],[0,0,0,1]]}]})";

SE3 imu_T_forward_camera() {
  SE3 T{{}, {0.5, -0.2, 0.1}};
  T.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T;
}

ReportRun forward_drive() {
  ReportRun drive = test::synthetic_drive({.states = 40, .landmarks = 5});
  drive.summary = kForwardCamera;
  for (const RunState& s : drive.run.states) {
    SE3 smoothed = s.world_T_imu;
    smoothed.p.x() += 0.25;
    drive.run.smoothed.push_back({.time = s.time, .world_T_imu = smoothed});
  }
  return drive;
}

// The rows of a table without the lines of `#`, split at that character.
std::vector<std::vector<std::string>> rows_of(const std::string& text, char comma) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    rows.emplace_back();
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, comma);) rows.back().push_back(word);
  }
  return rows;
}

double number(const std::string& text) { return std::stod(text); }

Eigen::Vector3d vector_at(const std::vector<std::string>& row, std::size_t at) {
  return {number(row.at(at)), number(row.at(at + 1)), number(row.at(at + 2))};
}

// A quaternion x y z w.
Eigen::Matrix3d rotation_at(const std::vector<std::string>& row, std::size_t at) {
  return Eigen::Quaterniond(number(row.at(at + 3)), number(row.at(at)), number(row.at(at + 1)),
                            number(row.at(at + 2)))
      .toRotationMatrix();
}

std::string input_error(const std::function<void()>& of) {
  try {
    of();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PathFiles, TumHasThePosesOfEitherPath) {
  const ReportRun drive = forward_drive();
  for (const RunPath path : {RunPath::kStates, RunPath::kSmoothed}) {
    const auto rows = rows_of(run_tum(drive.run, path), ' ');
    ASSERT_EQ(rows.size(), drive.run.states.size());
    const SE3& last = path == RunPath::kStates ? drive.run.states.back().world_T_imu
                                               : drive.run.smoothed.back().world_T_imu;
    EXPECT_EQ(vector_at(rows.back(), 1), last.p);
    EXPECT_LT((rotation_at(rows.back(), 4) - last.R).norm(), 1e-12);
  }
}

// A point one metre ahead of the camera, of which every wrong frame and every inverse misses.
TEST(PathFiles, KittiHasCamera0InTheAxesOfItsFirstPose) {
  const ReportRun drive = forward_drive();
  const KittiFiles files = run_kitti(drive, RunPath::kStates);
  const auto rows = rows_of(files.poses, ' ');
  const auto times = rows_of(files.times, ' ');
  ASSERT_EQ(rows.size(), drive.run.states.size());
  ASSERT_EQ(times.size(), rows.size());
  const SE3 world_T_first = drive.run.states[0].world_T_imu * imu_T_forward_camera();
  const Eigen::Vector3d ahead(0.1, 0.2, 1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 12);
    Eigen::Matrix<double, 3, 4> T;
    for (int k = 0; k < 12; ++k) T(k / 4, k % 4) = number(rows[i][static_cast<std::size_t>(k)]);
    const Eigen::Vector3d p_world = world_T_first * (T * ahead.homogeneous());
    const Eigen::Vector3d expected =
        drive.run.states[i].world_T_imu * (imu_T_forward_camera() * ahead);
    EXPECT_LT((p_world - expected).norm(), 1e-10);
    EXPECT_EQ(parse_seconds("", times[i][0]), drive.run.states[i].time);
  }
  ReportRun blind = forward_drive();
  for (const char* summary : {"{}", R"({"cameras": []})", R"({"cameras": [{"imu_T_cam": [[1]]}]})",
                              R"({"cameras": [{"imu_T_cam":
                                  [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})"}) {
    blind.summary = summary;
    EXPECT_NE(input_error([&] { run_kitti(blind, RunPath::kStates); }).find("imu_T_cam of camera"),
              std::string::npos)
        << summary;
  }
}

TEST(PathFiles, EurocHasTheStatesOfItsGroundTruth) {
  ReportRun drive = forward_drive();
  drive.run.extra_names = {"velocity_x",           "velocity_y",           "velocity_z",
                           "accelerometer_bias_x", "accelerometer_bias_y", "accelerometer_bias_z",
                           "gyroscope_bias_x",     "gyroscope_bias_y",     "gyroscope_bias_z"};
  for (RunState& s : drive.run.states) {
    s.extra = {1, 2, 3, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03};
    s.extra_sigma.assign(9, 1);
  }
  const auto rows = rows_of(run_euroc(drive.run, RunPath::kStates), ',');
  ASSERT_EQ(rows.size(), drive.run.states.size());
  const RunState& s = drive.run.states[30];
  ASSERT_EQ(rows[30].size(), 17);
  EXPECT_EQ(rows[30][0], std::to_string(s.time.count()));
  EXPECT_EQ(vector_at(rows[30], 1), s.world_T_imu.p);
  const Eigen::Quaterniond q(number(rows[30][4]), number(rows[30][5]), number(rows[30][6]),
                             number(rows[30][7]));
  EXPECT_LT((q.toRotationMatrix() - s.world_T_imu.R).norm(), 1e-12) << "w comes first";
  EXPECT_EQ(vector_at(rows[30], 8), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(vector_at(rows[30], 11), Eigen::Vector3d(0.01, 0.02, 0.03)) << "of the gyroscope";
  EXPECT_EQ(vector_at(rows[30], 14), Eigen::Vector3d(0.1, 0.2, 0.3));
  // The smoothed path, and a run without an IMU, have poses alone.
  EXPECT_EQ(rows_of(run_euroc(drive.run, RunPath::kSmoothed), ',').front().size(), 8);
  const std::string poses = run_euroc(forward_drive().run, RunPath::kStates);
  EXPECT_EQ(rows_of(poses, ',').front().size(), 8);
  EXPECT_EQ(poses.find("v_RS"), std::string::npos);
}

// The frames of the drive's states, with three before it was initialised. The cameras' clock is
// behind that of the states.
std::vector<Time> stamps_of(const ReportRun& drive, Time offset) {
  std::vector<Time> stamps;
  const Time interval = drive.run.states[1].time - drive.run.states[0].time;
  for (int k = 3; k > 0; --k) stamps.push_back(drive.run.states[0].time - k * interval - offset);
  for (const RunState& s : drive.run.states) stamps.push_back(s.time - offset);
  return stamps;
}

TEST(Umi, HasARowForEachFrameWithTheCamerasPoseInTheWorld) {
  ReportRun drive = forward_drive();
  drive.run.states[10].health = "lost";
  drive.run.states[11].world_T_imu.p.y() = std::nan("");
  const std::vector<Time> stamps = stamps_of(drive, Time::zero());
  const auto rows = rows_of(run_umi(drive, RunPath::kStates, stamps), ',');
  ASSERT_EQ(rows.size(), 1 + stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const auto& row = rows[i + 1];
    ASSERT_EQ(row.size(), 12);
    EXPECT_EQ(row[0], std::to_string(i));
    EXPECT_EQ(parse_seconds("", row[1]), stamps[i] - stamps[0]);
    const bool is_lost = i < 3 || i == 13 || i == 14;
    EXPECT_EQ(row[2], i < 3 ? "1" : is_lost ? "4" : "2") << "the state of ORB-SLAM3";
    EXPECT_EQ(row[3], is_lost ? "true" : "false");
    EXPECT_EQ(row[4], is_lost ? "false" : "true") << "the pipeline uses keyframes alone";
    if (is_lost) {
      for (std::size_t k = 5; k < 12; ++k) EXPECT_EQ(row[k], "0");
      continue;
    }
    const Eigen::Vector3d ahead(0.1, 0.2, 1);
    EXPECT_LT((rotation_at(row, 8) * ahead + vector_at(row, 5) -
               drive.run.states[i - 3].world_T_imu * (imu_T_forward_camera() * ahead))
                  .norm(),
              1e-10);
  }
}

TEST(Umi, FramesAreFoundByTheCamerasClock) {
  // Most of the interval of 104 ms: without the offset each frame would get its neighbour's pose.
  constexpr Time kOffset = std::chrono::milliseconds(90);
  ReportRun stated = forward_drive();
  const std::string expected = run_umi(stated, RunPath::kStates, stamps_of(stated, Time::zero()));
  const std::vector<Time> stamps = stamps_of(stated, kOffset);
  EXPECT_NE(run_umi(stated, RunPath::kStates, stamps), expected);
  stated.summary.replace(stated.summary.find("\"auto\""), 6, "0.09");
  EXPECT_EQ(run_umi(stated, RunPath::kStates, stamps), expected);
  ReportRun estimated = forward_drive();
  estimated.run.extra_names = {"time_offset"};
  for (RunState& s : estimated.run.states) s.extra = {0.0899};
  EXPECT_EQ(run_umi(estimated, RunPath::kStates, stamps), expected);
}

TEST(Umi, TheFramesOfAnotherRecordingAreAnError) {
  const ReportRun drive = forward_drive();
  const std::vector<Time> stamps = stamps_of(drive, std::chrono::hours(1));
  EXPECT_NE(input_error([&] {
              run_umi(drive, RunPath::kStates, stamps);
            }).find("no pose belongs to one of the 43 frames"),
            std::string::npos);
  EXPECT_NE(input_error([&] { run_umi(drive, RunPath::kStates, {}); }).find("of the 0 frames"),
            std::string::npos);
}

TEST(PathFiles, PosesThatAreNotFiniteAreLeftOut) {
  ReportRun drive = forward_drive();
  drive.run.states[0].world_T_imu.p.x() = std::nan("");
  drive.run.states[7].world_T_imu.R(0, 0) = std::nan("");
  const std::size_t left = drive.run.states.size() - 2;
  for (const std::string& text :
       {run_tum(drive.run, RunPath::kStates), run_kitti(drive, RunPath::kStates).poses,
        run_kitti(drive, RunPath::kStates).times, run_euroc(drive.run, RunPath::kStates)}) {
    EXPECT_EQ(rows_of(text, ' ').size(), left);
    EXPECT_EQ(text.find("nan"), std::string::npos);
  }
  for (RunState& s : drive.run.states) s.world_T_imu.p.x() = std::nan("");
  EXPECT_NE(input_error([&] { run_tum(drive.run, RunPath::kStates); }).find("none of its poses"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
