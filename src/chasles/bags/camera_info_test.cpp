#include <chasles/bags/camera_info.hpp>
#include <chasles/codec/bomb_testing.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/bag_calibration.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

RosCameraInfo info(const std::string& model, std::vector<double> D) {
  RosCameraInfo info{.height = 6, .width = 8, .distortion_model = model, .D = std::move(D)};
  info.K = {4, 0, 3.5, 0, 4.5, 2.5, 0, 0, 1};
  info.P = {5, 0, 3.25, -0.5, 0, 5.5, 2.25, 0, 0, 0, 1, 0};
  return info;
}

TEST(CameraInfo, LensesAreRead) {
  const Camera radtan = camera_of(info("plumb_bob", {-0.3, 0.1, 1e-3, 2e-3, 0}), false, "info");
  EXPECT_EQ(radtan.distortion, Distortion::kRadtan);
  EXPECT_EQ(radtan.coefficients, (LensCoefficients{-0.3, 0.1, 1e-3, 2e-3}));
  EXPECT_EQ(camera_of(info("plumb_bob", {-0.3, 0.1, 0, 0, 0.2}), false, "info").coefficients,
            (LensCoefficients{-0.3, 0.1, 0, 0, 0.2}));
  EXPECT_EQ(radtan.fx, 4);
  EXPECT_EQ(radtan.cy, 2.5);
  const Camera rational =
      camera_of(info("rational_polynomial", {-0.3, 0.1, 0, 0, 0, 0, 0, 0}), false, "info");
  EXPECT_EQ(rational.distortion, Distortion::kRadtan);
  EXPECT_EQ(rational.coefficients.size(), 4u);
  const auto coefficients = [](const std::string& model, const std::vector<double>& D) {
    return camera_of(info(model, D), false, "info").coefficients.size();
  };
  EXPECT_EQ(coefficients("rational_polynomial", {1, 2, 0, 0, 0, 3, 0, 0}), 8u);
  EXPECT_EQ(coefficients("rational_polynomial", {1, 2, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0}), 8u);
  EXPECT_EQ(coefficients("rational_polynomial", {1, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0}), 12u);
  EXPECT_EQ(coefficients("fisheye", {1e-2, 2e-2, 0, 1e-3, 0}), 4u);
  const Camera fisheye = camera_of(info("equidistant", {1e-2, 2e-2, 0, 1e-3}), false, "info");
  EXPECT_EQ(fisheye.distortion, Distortion::kEquidistant);
  EXPECT_EQ(camera_of(info("plumb_bob", {0, 0, 0, 0, 0}), false, "info").distortion,
            Distortion::kNone);
}

TEST(CameraInfo, RectifiedImagesHaveTheCameraOfP) {
  const Camera camera = camera_of(info("rational_polynomial", {1, 2, 3, 4, 5, 6, 7, 8}), true, "i");
  EXPECT_EQ(camera.distortion, Distortion::kNone);
  EXPECT_EQ(camera.fx, 5);
  EXPECT_EQ(camera.fy, 5.5);
  EXPECT_EQ(camera.cx, 3.25);
}

TEST(CameraInfo, OtherCamerasAreRejected) {
  const auto error = [](const RosCameraInfo& one) {
    return input_error([&] { camera_of(one, false, "topic /info"); });
  };
  expect_parts(
      error(info("rational_polynomial", {1, 2, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0.1, 0})),
      {"topic /info", "'rational_polynomial' with D = [1, 2", "14 coefficients", "tilted sensor"});
  expect_parts(error(info("plumb_bob", {-0.3, 0.1, 0, 0, 0, 0.2})), {"expected 4, 5, 8 or 12"});
  expect_parts(error(info("equidistant", {-0.3, 0.1, 0, 0, 0.2})), {"5 coefficients, expected 4"});
  expect_parts(error(info("cubic", {1})), {"'cubic' with D = [1]", "plumb_bob"});
  expect_parts(error(info("none", {-0.3, 0.1, 0, 0})), {"'none' with D"});
  expect_parts(error(info("plumb_bob", {-0.3})), {"D = [-0.3]"});
  RosCameraInfo other = info("plumb_bob", {});
  other.K[0] = 0;
  expect_parts(error(other), {"focal lengths are 0 and 4.5 px", "not calibrated"});
  other = info("plumb_bob", {});
  other.binning_x = 2;
  expect_parts(error(other), {"states binning 2 x 0"});
  other = info("plumb_bob", {});
  other.K[2] = std::nan("");
  expect_parts(error(other), {"not finite"});
}

/// Two topics of rectified images, 0.1 m apart by P, and the CameraInfo beside them.
BagContents rectified_pair(const std::string& frame0, const std::string& frame1) {
  const auto topic = [](const std::string& name, const std::string& type,
                        const std::string& frame) {
    TopicContents topic;
    topic.topic = {.name = name, .type = "sensor_msgs/" + type};
    topic.frame = frame;
    return topic;
  };
  BagContents contents;
  for (const bool right : {false, true}) {
    const std::string name = right ? "/right" : "/left", frame = right ? frame1 : frame0;
    TopicContents calibration = topic(name + "/camera_info", "CameraInfo", frame);
    calibration.info = info("plumb_bob", {});
    calibration.info->P[3] = right ? -0.5 : 0;
    const double turn = right ? -0.1 : 0.1;  // of the camera's own frame
    calibration.info->R = {
        1, 0, 0, 0, std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn)};
    contents.topics.push_back(calibration);
    contents.topics.push_back(topic(name + "/image_rect", "Image", frame));
  }
  contents.topics.push_back(topic("/imu", "Imu", "imu"));
  contents.transforms = {{"imu", "left", SE3{Eigen::Matrix3d::Identity(), {1, 2, 3}}},
                         {"imu", "right", SE3{Eigen::Matrix3d::Identity(), {1.1, 2, 3}}}};
  return contents;
}

Recording calibrated(const BagContents& contents) {
  ChosenTopics chosen;
  chosen.imu = &contents.topics[4];
  chosen.cameras = {&contents.topics[1], &contents.topics[3]};
  Recording recording;
  calibrate_by_bag("walk.bag", contents, chosen, recording);
  return recording;
}

TEST(CameraInfo, ARectifiedPairInOneFrameIsPlacedByP) {
  const Recording r = calibrated(rectified_pair("left", "left"));
  const SE3 cam1_T_cam0 = r.cameras[1].cam_T_imu * r.cameras[0].cam_T_imu.inverse();
  EXPECT_TRUE(cam1_T_cam0.R.isIdentity(1e-12)) << "the R of the frame's own camera";
  EXPECT_TRUE(cam1_T_cam0.p.isApprox(Eigen::Vector3d(-0.1, 0, 0), 1e-12));
}

TEST(CameraInfo, ARectifiedPairInTwoFramesIsPlacedByThem) {
  const Recording r = calibrated(rectified_pair("left", "right"));
  const Eigen::Vector3d p_cam1 = r.cameras[1].cam_T_imu * Eigen::Vector3d(1.1, 2, 3);
  EXPECT_LT(p_cam1.norm(), 1e-12);
}

// Drivers publish what is mounted firmly on /tf too.
TEST(CameraInfo, ConstantTransformsOfTfCountWhereTheStaticOnesLackThem) {
  BagContents contents = rectified_pair("left", "right");
  const std::vector<RosTransform> tree = std::exchange(contents.transforms, {});
  const auto publish = [&](double step, double turn) {
    MovingTransforms moving;
    for (int i = 0; i < 60; ++i) {
      for (RosTransform one : tree) {
        one.parent_T_child.p.x() += step * i;
        one.parent_T_child.R = so3::exp({0, turn * i, 0});
        moving.add(std::move(one));
      }
    }
    contents.moving = std::move(moving.all);
  };
  publish(0, 0);
  const Recording r = calibrated(contents);
  EXPECT_LT((r.cameras[1].cam_T_imu * Eigen::Vector3d(1.1, 2, 3)).norm(), 1e-12);
  ASSERT_EQ(r.remarks.size(), 4u);
  expect_parts(r.remarks[0], {"'imu' to 'left', published 60 times, moves by up to 0 m and 0 deg",
                              "taken from /tf"});
  expect_parts(r.remarks[1], {"calibrated by /left/camera_info and /tf ('imu' to 'left')"});
  publish(1e-7, 1e-7);
  EXPECT_EQ(calibrated(contents).cameras.size(), 2u) << "the noise of an attitude in floats";
  publish(0.01, 0);
  expect_parts(input_error([&] { calibrated(contents); }),
               {"its 0 static transforms", "/tf leads there, but 'imu' to 'left'",
                "moves by up to 0.59 m and 0 deg", "Kalibr's files"});
  publish(0, 0.01);
  expect_parts(input_error([&] { calibrated(contents); }), {"moves by up to 0 m and 34 deg"});
  // One of the two is static, and that one counts.
  contents.transforms = {tree[0]};
  publish(0, 0);
  contents.moving[0].first.parent_T_child.p.x() = 7;
  const Recording mixed = calibrated(contents);
  EXPECT_LT((mixed.cameras[0].cam_T_imu * Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((mixed.cameras[1].cam_T_imu * Eigen::Vector3d(1.1, 2, 3)).norm(), 1e-12);
}

// Of a depth camera's driver: the sensors that it does not rectify have the same name.
TEST(CameraInfo, ImagesNamedRectRawHaveTheLensThatIsStated) {
  BagContents contents = rectified_pair("left", "right");
  for (const std::size_t i : {0, 2}) {
    RosCameraInfo& lens = *contents.topics[i].info;
    lens = info("plumb_bob", {-0.3, 0.1, 0, 0});
    lens.P[3] = 0;
    lens.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  }
  EXPECT_EQ(calibrated(contents).cameras[0].distortion, Distortion::kNone) << "image_rect";
  contents.topics[1].topic.name = "/left/image_rect_raw";
  contents.topics[3].topic.name = "/right/image_rect_raw/compressed";
  for (const Camera& camera : calibrated(contents).cameras) {
    EXPECT_EQ(camera.coefficients, (LensCoefficients{-0.3, 0.1, 0, 0}));
    EXPECT_EQ(camera.fx, 4) << "of K";
  }
}

TEST(CameraInfo, AChainIsTheShortest) {
  const std::vector<RosTransform> tree{
      {"base", "imu", {}}, {"odom", "base", {}}, {"base", "mast", {}}, {"mast", "camera", {}}};
  EXPECT_EQ(find_chain(tree, "camera", "imu"), (std::vector<std::size_t>{3, 2, 0}));
  EXPECT_EQ(find_chain(tree, "imu", "imu"), std::vector<std::size_t>{});
  EXPECT_FALSE(find_chain(tree, "x", "imu"));
}

TEST(CameraInfo, TwoCamerasAtOnePlaceAreRejected) {
  BagContents contents = rectified_pair("left", "left");
  contents.topics[2].info->P[3] = 0;
  contents.topics[2].info->R = contents.topics[0].info->R;
  expect_parts(
      input_error([&] { calibrated(contents); }),
      {"walk.bag: cam0 and cam1 are at the same place", "/right/image_rect", "Kalibr's files"});
}

TEST(StaticTransforms, AreComposedInBothDirections) {
  const SE3 a = se3::exp((Vector6d() << 0.1, -0.2, 0.3, 1, 2, 3).finished());
  const SE3 b = se3::exp((Vector6d() << -0.5, 0.4, 0.2, -1, 0.5, 2).finished());
  const std::vector<RosTransform> tree{{"base", "imu", a}, {"base", "camera", b}, {"x", "y", a}};
  const auto found = find_transform(tree, "camera", "imu");
  ASSERT_TRUE(found);
  const SE3 expected = b.inverse() * a;
  EXPECT_TRUE(found->R.isApprox(expected.R, 1e-14));
  EXPECT_TRUE(found->p.isApprox(expected.p, 1e-14));
  EXPECT_TRUE(find_transform(tree, "imu", "imu")->p.isZero(0));
  EXPECT_FALSE(find_transform(tree, "x", "imu"));
}

TEST(StaticTransforms, ALongChainTakesTimeInProportion) {
  std::vector<RosTransform> chain;
  const SE3 step{Eigen::Matrix3d::Identity(), {1, 0, 0}};
  for (int i = 0; i < 100'000; ++i) {
    chain.push_back({"f" + std::to_string(i + 1), "f" + std::to_string(i), step});
  }
  const test::BombStopwatch quick;
  EXPECT_EQ(find_transform(chain, "f100000", "f0")->p.x(), 100'000);
}

}  // namespace
}  // namespace chasles
