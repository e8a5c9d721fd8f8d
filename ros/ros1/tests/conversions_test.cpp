#include "conversions.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/base/error.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles::ros1 {
namespace {

using test::image_message;
using test::kStamp;
using test::picture;

const ImageSize kSize{.width = 8, .height = 6};

RawMessage raw(const std::string& bytes) { return {"sensor_msgs/Image", bytes}; }

RawMessage packed(const std::string& picture) {
  std::string bytes = test::message_header(kStamp);
  test::put_text(bytes, "png");
  test::put_text(bytes, picture);
  return {"sensor_msgs/CompressedImage", bytes};
}

TEST(Ros1Conversions, ImagesAreGreyWhateverTheirTransport) {
  const cv::Mat image = picture(10);
  const std::vector<std::uint8_t> pixels(image.datastart, image.dataend);
  EXPECT_EQ(image_of(raw(image_message(kStamp, image, "mono8")), kSize, 16, "cam").pixels, pixels);
  EXPECT_EQ(image_of(packed(test::encoded(image)), kSize, 16, "cam").pixels, pixels);
}

TEST(Ros1Conversions, DeepImagesLoseTheBitsThatAreNotInUse) {
  cv::Mat deep(6, 8, CV_16UC1, cv::Scalar(0x0fff));
  const RawMessage message = raw(image_message(kStamp, deep, "mono16"));
  EXPECT_EQ(bits_of(message, kSize, "cam"), 12);
  EXPECT_EQ(image_of(message, kSize, 12, "cam").pixels[0], 255);
  EXPECT_EQ(image_of(message, kSize, 16, "cam").pixels[0], 15);
  EXPECT_EQ(bits_of(raw(image_message(kStamp, picture(10), "mono8")), kSize, "cam"), 16);
  EXPECT_EQ(bits_of(packed(test::encoded(deep)), kSize, "cam"), 12);
}

TEST(Ros1Conversions, WhatIsNoImageIsAnError) {
  const auto error_of = [](const RawMessage& message, const ImageSize& size) {
    return test::input_error([&] { image_of(message, size, 16, "topic /cam"); });
  };
  const std::string bytes = image_message(kStamp, picture(10), "mono8");
  test::expect_parts(error_of({"sensor_msgs/Imu", bytes}, kSize),
                     {"topic /cam", "sensor_msgs/Imu", "expected sensor_msgs/Image"});
  test::expect_parts(error_of(raw(bytes), {.width = 7, .height = 6}), {"8 x 6", "7 x 6"});
  test::expect_parts(error_of(raw(bytes.substr(0, 40)), kSize), {"topic /cam"});
  test::expect_parts(error_of(packed("no picture"), kSize), {"topic /cam"});
}

TEST(Ros1Conversions, StampsHoldTimesFrom1970To2106) {
  EXPECT_EQ(header_of(kStamp, "odom").stamp, kStamp.count());
  EXPECT_EQ(header_of(kStamp, "odom").frame, "odom");
  EXPECT_THROW(header_of(Time(-1), "odom"), InputError);
  EXPECT_THROW(header_of(std::chrono::seconds(1LL << 32), "odom"), InputError);
}

TEST(Ros1Conversions, APoseIsAPositionAndAUnitQuaternion) {
  const OutPose pose = pose_of({so3::exp({0, 0, 2}), {1, 2, 3}});
  EXPECT_EQ(pose.position[2], 3);
  EXPECT_NEAR(pose.quaternion_xyzw[2], std::sin(1), 1e-15);
  EXPECT_NEAR(pose.quaternion_xyzw[3], std::cos(1), 1e-15);
}

TEST(Ros1Conversions, AnOdometryIsABodysState) {
  BodyState body{.world_T_body = {Eigen::Matrix3d::Identity(), {1, 2, 3}},
                 .linear = {4, 5, 6},
                 .angular = {7, 8, 9}};
  body.pose_covariance(1, 5) = 0.5;
  body.twist_covariance(2, 3) = 0.25;
  const OutOdometry out = odometry_of(kStamp, body, "odom", "base_link");
  EXPECT_EQ(out.pose.header.frame, "odom");
  EXPECT_EQ(out.child, "base_link");
  EXPECT_EQ(out.pose.covariance[6 * 1 + 5], 0.5);
  EXPECT_EQ(out.twist_covariance[6 * 2 + 3], 0.25);
  EXPECT_EQ(out.linear[1], 5);
  EXPECT_EQ(out.angular[0], 7);
}

TEST(Ros1Conversions, ABodysPlaceInAMapIsThatOfItsImu) {
  PoseInMap place;
  place.map_T_imu = {so3::exp({0, 0, M_PI / 2}), {1, 0, 0}};
  place.covariance(2, 2) = 0.04;  // rotation about z
  const SE3 imu_T_body{Eigen::Matrix3d::Identity(), {2, 0, 0}};
  const auto [pose, covariance] = body_in_map(place, imu_T_body.inverse());
  EXPECT_TRUE(pose.p.isApprox(Eigen::Vector3d(1, 2, 0)));
  EXPECT_NEAR(covariance(0, 0), 0.04 * 4, 1e-12);  // the body swings about the IMU
  EXPECT_NEAR(covariance(1, 1), 0, 1e-12);
  EXPECT_NEAR(covariance(5, 5), 0.04, 1e-12);
}

TEST(Ros1Conversions, PointsHaveTheRootOfTheirTraceAsSigma) {
  MapLandmark landmark;
  landmark.p_world = {1, 2, 3};
  landmark.covariance = Eigen::Vector3d(0.04, 0.05, 0.16).asDiagonal();
  const OutPoints points = points_of(kStamp, "odom", std::vector{landmark});
  EXPECT_EQ(points.points.at(0), (std::array<float, 4>{1, 2, 3, 0.5f}));
}

TEST(Ros1Conversions, TheMotionOfAPredictedStateKeepsItsCovariance) {
  PredictedState state;
  state.state.v_world = {1, 2, 3};
  state.covariance(14, 6) = 0.5;
  const ImuMotion motion = motion_of(state, 0.25);
  EXPECT_EQ(motion.v_world, state.state.v_world);
  EXPECT_EQ(motion.covariance(14, 6), 0.5);
  EXPECT_EQ(motion.rate_variance, 0.25);
}

}  // namespace
}  // namespace chasles::ros1
