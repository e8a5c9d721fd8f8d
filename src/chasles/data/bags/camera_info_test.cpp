#include <chasles/data/bags/camera_info.hpp>
#include <chasles/data/testing.hpp>

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

TEST(CameraInfo, LensesOfFourCoefficientsAreRead) {
  const Camera radtan = camera_of(info("plumb_bob", {-0.3, 0.1, 1e-3, 2e-3, 0}), false, "info");
  EXPECT_EQ(radtan.distortion, Distortion::kRadtan);
  EXPECT_EQ(radtan.coefficients, Eigen::Vector4d(-0.3, 0.1, 1e-3, 2e-3));
  EXPECT_EQ(radtan.fx, 4);
  EXPECT_EQ(radtan.cy, 2.5);
  const Camera rational =
      camera_of(info("rational_polynomial", {-0.3, 0.1, 0, 0, 0, 0, 0, 0}), false, "info");
  EXPECT_EQ(rational.distortion, Distortion::kRadtan);
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

TEST(CameraInfo, OtherCamerasAreRefused) {
  const auto error = [](const RosCameraInfo& one) {
    return input_error([&] { camera_of(one, false, "topic /info"); });
  };
  expect_parts(error(info("rational_polynomial", {1, 2, 0, 0, 0, 3, 0, 0})),
               {"topic /info", "'rational_polynomial' with D = [1, 2", "expected plumb_bob"});
  expect_parts(error(info("plumb_bob", {-0.3, 0.1, 0, 0, 0.2})), {"no further coefficient"});
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

}  // namespace
}  // namespace chasles
