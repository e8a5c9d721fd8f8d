#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <unistd.h>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/image_messages.hpp>
#include <chasles/viewers/map_messages.hpp>
#include <chasles/viewers/run_mcap.hpp>

namespace chasles {
namespace {

using nlohmann::json;
using test::synthetic_drive;

// The content that Foxglove's own libraries find in the file (src/web/tests/read_mcap.mjs). They
// fail on a wrong check sum, index, schema or message.
json read_back(const std::string& bytes) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("chasles_mcap_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  write_file(folder / "run.mcap", bytes);
  const std::string command =
      "'" CHASLES_NODE "' '" CHASLES_SOURCE_DIR "/src/web/tests/read_mcap.mjs' '" +
      (folder / "run.mcap").string() + "' '" + (folder / "report.json").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  json report = json::parse(read_file(folder / "report.json"));
  std::filesystem::remove_all(folder);
  return report;
}

Eigen::Vector3d vector(const json& v) {
  const auto part = [&](const char* axis) { return v.value(axis, 0.0); };
  return {part("x"), part("y"), part("z")};
}

SE3 pose(const json& v) {
  const json& q = v.at("orientation");
  return {checked_quaternion(
              "", {q.value("x", 0.0), q.value("y", 0.0), q.value("z", 0.0), q.value("w", 0.0)}),
          vector(v.at("position"))};
}

float float_at(const json& bytes, std::size_t at) {
  std::uint32_t bits = 0;
  for (unsigned k = 0; k < 4; ++k) bits |= bytes.at(at + k).get<std::uint32_t>() << (8 * k);
  return std::bit_cast<float>(bits);
}

TEST(Mcap, FoxgloveReadsWhatTheRunHas) {
  ReportRun drive = synthetic_drive({.states = 1500, .landmarks = 300});
  drive.run.georeference = {{.latitude = 49, .longitude = 8.4, .altitude = 110}};
  drive.summary =
      R"({"chart": "standard", "cameras": [{"imu_T_cam": [[0,0,1,0.5],[-1,0,0,0],[0,-1,0,0.1],
          [0,0,0,1]]}]})";
  drive.run.extra_names[0] = "velocity_x_m/s";
  const auto& run = drive.run;
  const json found = read_back(run_mcap(drive, "1.2.3"));
  const json& topics = found.at("topics");
  EXPECT_EQ(found.at("library"), "chasles 1.2.3");
  EXPECT_GT(found.at("records").at("Chunk"), 1) << "a window of time is to be found";
  EXPECT_EQ(found.at("begin"), std::to_string(run.states.front().time.count()));
  EXPECT_EQ(found.at("end"), std::to_string(run.states.back().time.count()));
  for (const char* topic :
       {"/tf", "/pose", "/odometry", "/state", "/errors", "/truth/pose", "/location"}) {
    EXPECT_EQ(topics.at(topic).at("count"), run.states.size()) << topic;
  }

  const RunState& last = run.states.back();
  const json& odometry = topics.at("/odometry").at("last");
  EXPECT_LT((vector(odometry["pose"]["position"]) - last.world_T_imu.p).norm(), 1e-12);
  EXPECT_LT((pose(odometry["pose"]).R - last.world_T_imu.R).norm(), 1e-12);
  EXPECT_EQ(odometry["pose_covariance"].size(), 36u);
  EXPECT_EQ(odometry["pose_covariance"][0], last.pose_covariance(3, 3)) << "x comes first";
  EXPECT_EQ(odometry["pose_covariance"][5], last.pose_covariance(3, 2));
  EXPECT_EQ(odometry["pose_covariance"][35], last.pose_covariance(2, 2));
  const json& transform = topics.at("/tf").at("last").at("transforms").at(0);
  EXPECT_EQ(transform.at("parent_frame_id"), "world");
  EXPECT_EQ(transform.at("child_frame_id"), "imu");
  EXPECT_LT((vector(transform["translation"]) - last.world_T_imu.p).norm(), 1e-12);
  const json& camera = topics.at("/tf_cameras").at("last").at("transforms").at(0);
  EXPECT_EQ(camera.at("child_frame_id"), "cam0");
  EXPECT_EQ(vector(camera["translation"]), Eigen::Vector3d(0.5, 0, 0.1));

  const json& state = topics.at("/state").at("last");
  EXPECT_EQ(state.at("nis"), last.nis);
  EXPECT_EQ(state.at("health"), last.health);
  EXPECT_EQ(state.at("landmarks"), last.landmarks);
  EXPECT_EQ(state.at("velocity_x_m_s"), last.extra[0]) << "a name without what may not stand in it";
  EXPECT_EQ(state.at("sigma_velocity_x_m_s"), last.extra_sigma[0]);
}

TEST(Mcap, TextsAreUtf8AsProtocolBuffersDemand) {
  ReportRun drive = synthetic_drive({.states = 20, .landmarks = 3});
  drive.run.states.back().health = "caf\xe9";
  drive.run.extra_names[0] = "caf\xe9";
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  EXPECT_EQ(topics.at("/state").at("last").at("health"), "caf\xef\xbf\xbd");
  EXPECT_EQ(topics.at("/state").at("last").at("caf_"), drive.run.states.back().extra[0]);
}

TEST(Mcap, ATruthThatCannotBeComparedLeavesTheRest) {
  ReportRun drive = synthetic_drive({.states = 20, .landmarks = 3});
  drive.run.georeference = {{.latitude = 49, .longitude = 8.4, .altitude = 110}};
  for (StampedPose& s : drive.run.truth) s.time += std::chrono::hours(24);
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  EXPECT_EQ(topics.at("/pose").at("count"), 20);
  EXPECT_FALSE(topics.contains("/location"));
  EXPECT_EQ(topics.at("/ways").at("last").at("entities").size(), 2u)
      << "a truth that cannot be compared has no place in this world";
}

TEST(Mcap, TheMapIsThereAsACloudAndAsEllipsoids) {
  ReportRun drive = synthetic_drive({.states = 50, .landmarks = 300});
  drive.run.landmarks[7].p_world.x() = kNaN;
  drive.run.landmarks[8].covariance(1, 1) = kNaN;
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  const json& cloud = topics.at("/map").at("last");
  ASSERT_EQ(cloud["point_stride"], 20);
  ASSERT_EQ(cloud["data"].size(), 20u * 298) << "those that are not finite are left out";
  const RunLandmark& l = drive.run.landmarks[9];  // the eighth that is drawn
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(float_at(cloud["data"], 20 * 7 + 4 * k), static_cast<float>(l.p_world[k]));
  }
  EXPECT_EQ(float_at(cloud["data"], 20 * 7 + 12),
            static_cast<float>(std::sqrt(l.covariance.trace())));
  const json& spheres = topics.at("/map/ellipsoids").at("last").at("entities").at(0).at("spheres");
  ASSERT_EQ(spheres.size(), 298u);
  EXPECT_LT((pose(spheres[7]["pose"]).p - l.p_world).norm(), 1e-12);
}

TEST(Mcap, TheFrameOfAMapIsAboveTheWorldOncePlaced) {
  ReportRun drive = synthetic_drive({.states = 50, .landmarks = 30, .prior_map = true});
  auto& run = drive.run;
  const SE3 map_T_world = run.prior_map->world_T_map.inverse();
  for (std::size_t i = 20; i < run.states.size(); ++i) {
    run.in_map.push_back(
        {.time = run.states[i].time, .world_T_imu = map_T_world * run.states[i].world_T_imu});
  }
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  EXPECT_EQ(topics.at("/tf_map").at("count"), 30);
  const json& transform = topics.at("/tf_map").at("last").at("transforms").at(0);
  EXPECT_EQ(transform.at("parent_frame_id"), "map");
  EXPECT_EQ(transform.at("child_frame_id"), "world");
  EXPECT_LT((vector(transform["translation"]) - map_T_world.p).norm(), 1e-9);
  const json& cloud = topics.at("/map/prior").at("last");
  EXPECT_EQ(cloud["frame_id"], "map");
  ASSERT_EQ(cloud["point_stride"], 22);
  ASSERT_EQ(cloud["data"].size(), 22u * 30);
  for (std::size_t i = 0; i < 30; ++i) {
    const SketchPoint& l = run.prior_map->points[i];
    EXPECT_EQ(float_at(cloud["data"], 22 * i), static_cast<float>(l.p_map.x()));
    EXPECT_EQ(cloud["data"][22 * i + 20], l.session);
    EXPECT_EQ(cloud["data"][22 * i + 21], i % 6 == 0 ? 1 : 0) << "whether it returned";
  }
}

TEST(Mcap, ClosuresAreMarkedWhereTheyWere) {
  ReportRun drive = synthetic_drive({.states = 50, .landmarks = 3});
  const auto summary_at = [](Time time) {
    return R"({"closures": [{"time_ns": )" + std::to_string(time.count()) +
           R"(, "landmarks": 6, "moved_m": 0.25, "chi2": 8.5, "chi2_dof": 12}]})";
  };
  drive.summary = summary_at(drive.run.states[30].time);
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  EXPECT_EQ(topics.at("/closures").at("count"), 1);
  const json& entity = topics.at("/closures").at("last").at("entities").at(0);
  EXPECT_LT((pose(entity["spheres"][0]["pose"]).p - drive.run.states[30].world_T_imu.p).norm(),
            1e-12);
  EXPECT_EQ(entity["texts"][0]["text"], "6 landmarks, 0.250 m, chi2 8.5 of 12");
  drive.summary = R"({"closures": [{"landmarks": 6}]})";
  EXPECT_THROW(run_mcap(drive, "0"), InputError);
}

TEST(Mcap, KeptImagesAreThereWithWhatWasSeenInThem) {
  ReportRun drive = synthetic_drive({.states = 50, .landmarks = 0});
  test::add_synthetic_images(drive.run, 10);
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  const ShownImage& image = drive.run.images[8];  // the last of camera 0
  const json& picture = topics.at("/cam0/image");
  EXPECT_EQ(picture.at("count"), 5);
  EXPECT_EQ(picture.at("last").at("format"), "jpeg");
  EXPECT_EQ(picture.at("last").at("frame_id"), "cam0");
  std::string bytes;
  for (const json& byte : picture.at("last").at("data")) {
    bytes.push_back(static_cast<char>(byte.get<int>()));
  }
  EXPECT_EQ(bytes, image.jpeg);
  EXPECT_FALSE(topics.contains("/cam1/image")) << "it has none";

  const json& seen = topics.at("/cam0/annotations").at("last");
  EXPECT_EQ(topics.at("/cam1/annotations").at("count"), 5);
  ASSERT_EQ(seen.at("circles").size(), 3u) << "of twelve, each fourth was used";
  const Eigen::Vector2d pixel = image.features[2].seen.observation.pixel;
  EXPECT_NEAR(seen["circles"][0]["position"]["x"].get<double>(), pixel.x() / 2, 1e-9);
  EXPECT_NEAR(seen["circles"][0]["position"]["y"].get<double>(), pixel.y() / 2, 1e-9);
  // Twelve tails, three crosses, squares and dots, six ellipses; of the other camera, which has no
  // picture, in its own pixels.
  EXPECT_EQ(seen.at("points").size(), 12u + 9 + 6);
  const json& other = topics.at("/cam1/annotations").at("last");
  EXPECT_NEAR(other["circles"][0]["position"]["x"].get<double>(), pixel.x(), 1e-9);
}

TEST(Mcap, AnEllipsesCornersAreThatManySigmaAway) {
  ExpectedPixel expected{.pixel = {30, 40}, .covariance = Eigen::Matrix2d::Zero()};
  expected.covariance << 2, -0.7, -0.7, 0.5;
  const auto corners = ellipse_points(expected, 3);
  ASSERT_GE(corners.size(), 12u);
  for (const Eigen::Vector2d& corner : corners) {
    const Eigen::Vector2d r = corner - expected.pixel;
    EXPECT_NEAR(r.dot(expected.covariance.inverse() * r), 9, 1e-9);
  }
  expected.covariance(0, 0) = -1;
  EXPECT_TRUE(ellipse_points(expected, 3).empty());
}

TEST(Mcap, AnEllipsoidsRimIsWhereTheSquareIsTheQuantile) {
  Eigen::Matrix3d P;
  P << 2, 0.3, -0.1, 0.3, 0.5, 0.2, -0.1, 0.2, 0.9;
  const Ellipsoid shape = ellipsoid_95(P);
  EXPECT_NEAR(shape.axes.determinant(), 1, 1e-12);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d rim = shape.radii(k) * shape.axes.col(k);
    EXPECT_NEAR(rim.dot(P.inverse() * rim), chi2_quantile(0.95, 3), 1e-9);
  }
}

TEST(Mcap, PosesThatAreNotFiniteAreLeftOutAndTheFiguresStay) {
  ReportRun drive = synthetic_drive({.states = 60, .landmarks = 0, .dead_reckoning = false});
  for (std::size_t k = 50; k < 60; ++k) {
    drive.run.states[k].world_T_imu.p.setConstant(kNaN);
    drive.run.states[k].nis = kNaN;
  }
  const json topics = read_back(run_mcap(drive, "0")).at("topics");
  EXPECT_EQ(topics.at("/pose").at("count"), 50);
  EXPECT_EQ(topics.at("/state").at("count"), 60);
  const json& ways = topics.at("/ways").at("last").at("entities");
  ASSERT_EQ(ways.size(), 2u) << "the truth is placed by the others";
  EXPECT_EQ(ways.at(0).at("lines").at(0).at("points").size(), 50u);
  EXPECT_EQ(topics.at("/truth/pose").at("count"), 50);
}

TEST(Mcap, HostileNamesBecomeNamesOfFields) {
  ReportRun drive = synthetic_drive({.states = 5, .landmarks = 0});
  drive.run.extra_names[0] = "<b>";
  drive.run.extra_names[1] = "{b}";  // the same, once cleaned
  drive.run.extra_names[2] = "health";
  drive.run.extra_names[3] = "";
  const json state = read_back(run_mcap(drive, "0")).at("topics").at("/state").at("last");
  const RunState& last = drive.run.states.back();
  EXPECT_EQ(state.at("value__b_"), last.extra[0]);
  EXPECT_EQ(state.at("value__b__"), last.extra[1]);
  EXPECT_EQ(state.at("health_"), last.extra[2]);
  EXPECT_EQ(state.at("value_"), last.extra[3]);
}

TEST(Mcap, TheSameEstimatesGiveTheSameBytesWhateverTheyTook) {
  ReportRun drive = synthetic_drive({.states = 40, .landmarks = 20});
  const std::string first = run_mcap(drive, "0");
  for (RunState& s : drive.run.states) s.milliseconds *= 2;
  EXPECT_EQ(run_mcap(drive, "0"), first);
}

TEST(Mcap, ARunWithoutStatesIsAFileWithoutMessages) {
  EXPECT_TRUE(run_mcap({}, "0").starts_with("\x89MCAP0\r\n"));
}

TEST(Mcap, WhatCannotBeWrittenIsRejected) {
  ReportRun drive = synthetic_drive({.states = 5, .landmarks = 0, .truth = false});
  drive.summary = "[]";
  EXPECT_THROW(run_mcap(drive, "0"), InputError);
  drive.summary = R"({"cameras": [{"imu_T_cam": [[1, 2]]}]})";
  EXPECT_THROW(run_mcap(drive, "0"), InputError);
  drive.summary.clear();
  drive.run.states[0].time = Time(-1);
  EXPECT_THROW(run_mcap(drive, "0"), InputError);
}

}  // namespace
}  // namespace chasles
