#include <cmath>
#include <initializer_list>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

void put_all(std::string& bytes, std::initializer_list<double> numbers) {
  for (const double number : numbers) test::put(bytes, number);
}

Time stamp_of(int i) { return test::kStamp + i * Time(10'000'000); }

// Poses at (i, 2, 3), a quarter turn to the left.
void put_pose(std::string& bytes, int i) {
  put_all(bytes, {1.0 * i, 2, 3, 0, 0, std::sqrt(0.5), std::sqrt(0.5)});
}

std::string transform_message(int i, const std::string& child) {
  std::string bytes = test::message_header(stamp_of(i));
  test::put_text(bytes, child);
  put_pose(bytes, i);
  return bytes;
}

// One message of a type.
std::string pose_message(const std::string& type, int i) {
  if (type == "tf2_msgs/TFMessage") {
    std::string bytes;
    test::put(bytes, std::uint32_t{2});
    return bytes + transform_message(i, "imu") + transform_message(i, "other");
  }
  if (type == "geometry_msgs/TransformStamped") return transform_message(i, "imu");
  std::string bytes = test::message_header(stamp_of(i));
  if (type == "nav_msgs/Odometry") test::put_text(bytes, "imu");
  if (type == "geometry_msgs/PointStamped") {
    put_all(bytes, {1.0 * i, 2, 3});
    return bytes;
  }
  put_pose(bytes, i);
  return bytes + std::string(36 * sizeof(double), '\0');  // a covariance, or more that is not read
}

std::filesystem::path bag_of(const std::string& type) {
  std::vector<std::string> messages;
  for (int i = 0; i < 3; ++i) messages.push_back(pose_message(type, i));
  const auto file = test::scratch() / "walk.mcap";
  test::spill(file, test::mcap_of("/gt", type, messages));
  return file;
}

TEST(BagTruth, PosesOfEveryTypeAreRead) {
  for (const char* type :
       {"geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped", "nav_msgs/Odometry",
        "geometry_msgs/TransformStamped", "geometry_msgs/PointStamped", "tf2_msgs/TFMessage"}) {
    std::vector<std::string> remarks;
    const std::string topic = type == std::string("tf2_msgs/TFMessage") ? "/gt:imu" : "";
    const TruthTable table = read_bag_truth(bag_of(type), topic, remarks);
    ASSERT_EQ(table.poses.size(), 3u) << type;
    EXPECT_EQ(table.poses[2].time, stamp_of(2)) << type;
    EXPECT_EQ(table.poses[2].pose.p, Eigen::Vector3d(2, 2, 3)) << type;
    EXPECT_EQ(table.attitudes, type != std::string("geometry_msgs/PointStamped")) << type;
    const Eigen::Vector3d forward = table.poses[2].pose.R.col(0);
    const Eigen::Vector3d expected =
        table.attitudes ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    EXPECT_LT((forward - expected).norm(), 1e-12) << type;
    ASSERT_EQ(remarks.size(), 2u) << type;  // the first one: the test's bag was not closed
    EXPECT_NE(remarks[1].find("/gt"), std::string::npos) << remarks[1];
  }
}

TEST(BagTruth, AnOpenChoiceIsAnError) {
  std::vector<std::string> remarks;
  const auto bag = bag_of("tf2_msgs/TFMessage");
  expect_parts(input_error([&] { read_bag_truth(bag, "", remarks); }),
               {"walk.mcap: has several topics of poses", "/gt:imu", "/gt:other", "3 poses"});
  expect_parts(input_error([&] { read_bag_truth(bag, "/odom", remarks); }),
               {"found no poses of '/odom', expected one of", "/gt:imu"});
  expect_parts(input_error([&] { read_bag_truth(bag_of("std_msgs/String"), "", remarks); }),
               {"has no poses to be a truth", "/gt (std_msgs/String)"});
}

}  // namespace
}  // namespace chasles
