#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include "ros_messages.hpp"

// The messages against what their definitions say.
namespace chasles::ros1 {
namespace {

OutPoseWithCovariance some_pose() {
  OutPoseWithCovariance pose{{1403636584763555584, "odom"}, {{1, 2, 3}, {0.5, -0.5, 0.5, 0.5}}, {}};
  for (std::size_t i = 0; i < 36; ++i) pose.covariance[i] = static_cast<double>(i);
  return pose;
}

TEST(Ros1Messages, AnOdometryHasBothFramesAndBothCovariances) {
  OutOdometry out{some_pose(), "base_link", {4, 5, 6}, {7, 8, 9}, {}};
  out.twist_covariance[35] = 0.25;
  const nav_msgs::Odometry message = message_of(out);
  EXPECT_EQ(message.header.stamp, ros::Time(1403636584, 763555584));
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.pose.pose.position.z, 3);
  EXPECT_EQ(message.pose.pose.orientation.y, -0.5);
  EXPECT_EQ(message.pose.covariance[6 * 2 + 5], 17);
  EXPECT_EQ(message.twist.twist.linear.x, 4);
  EXPECT_EQ(message.twist.twist.angular.z, 9);
  EXPECT_EQ(message.twist.covariance[35], 0.25);
}

TEST(Ros1Messages, APathHasTheStampsOfItsPoses) {
  OutPath out;
  out.header = {3'000'000'001, "odom"};
  out.poses.emplace_back(1'500'000'000, OutPose{{1, 0, 0}, {0, 0, 0, 1}});
  out.poses.emplace_back(3'000'000'001, OutPose{{2, 0, 0}, {0, 0, 0, 1}});
  const nav_msgs::Path message = message_of(out);
  ASSERT_EQ(message.poses.size(), 2u);
  EXPECT_EQ(message.poses[0].header.stamp, ros::Time(1, 500'000'000));
  EXPECT_EQ(message.poses[1].header.frame_id, "odom");
  EXPECT_EQ(message.poses[1].pose.position.x, 2);
  EXPECT_EQ(message.poses[1].pose.orientation.w, 1);
}

// By ROS's own reader of clouds.
TEST(Ros1Messages, PointsAreReadByName) {
  OutPoints out;
  EXPECT_TRUE(message_of(out).data.empty());
  out.points = {{1, 2, 3, 0.5f}, {4, 5, 6, 0.25f}};
  const sensor_msgs::PointCloud2 message = message_of(out);
  EXPECT_EQ(message.width * message.height, 2u);
  sensor_msgs::PointCloud2ConstIterator<float> y(message, "y"), sigma(message, "sigma");
  EXPECT_EQ(*y, 2);
  EXPECT_EQ(*sigma, 0.5f);
  ++y;
  ++sigma;
  EXPECT_EQ(*y, 5);
  EXPECT_EQ(*sigma, 0.25f);
}

TEST(Ros1Messages, TransformsLeadFromChildToParent) {
  const tf2_msgs::TFMessage message =
      message_of(std::vector<OutTransform>{{{5, "map"}, "odom", {{1, 2, 3}, {0, 0, 1, 0}}}});
  ASSERT_EQ(message.transforms.size(), 1u);
  EXPECT_EQ(message.transforms[0].header.frame_id, "map");
  EXPECT_EQ(message.transforms[0].child_frame_id, "odom");
  EXPECT_EQ(message.transforms[0].transform.translation.y, 2);
  EXPECT_EQ(message.transforms[0].transform.rotation.z, 1);
}

TEST(Ros1Messages, ADiagnosisIsAStatus) {
  const OutDiagnosis out{DiagnosisLevel::kWarning, "no images come", {{"frames", "7"}}};
  const auto message = message_of(out, "chasles", ros::Time(8, 9));
  EXPECT_EQ(message.header.stamp, ros::Time(8, 9));
  ASSERT_EQ(message.status.size(), 1u);
  EXPECT_EQ(message.status[0].level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(message.status[0].name, "chasles");
  EXPECT_EQ(message.status[0].message, "no images come");
  EXPECT_EQ(message.status[0].values.at(0).key, "frames");
  EXPECT_EQ(message.status[0].values.at(0).value, "7");
}

}  // namespace
}  // namespace chasles::ros1
