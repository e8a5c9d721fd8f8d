#include <chasles/base/constants.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

// Different focal lengths, so that the tests detect a confusion of the axes.
const StereoRig kRig{
    .fx = 552.6, .fy = 538.2, .cx = 682.1, .cy = 238.8, .baseline = 0.6, .cam0_T_imu = {}};

// Points from just in front of the pair to 200 m away, off the axis on all sides.
std::vector<Eigen::Vector3d> points() {
  std::vector<Eigen::Vector3d> all;
  for (const double z : {0.2, 1.0, 8.0, 40.0, 200.0}) {
    for (const double x : {-0.7, 0.0, 0.9}) {
      for (const double y : {-0.3, 0.0, 0.4}) all.emplace_back(x * z, y * z, z);
    }
  }
  return all;
}

TEST(Stereo, APointOnTheAxisIsSeenAtThePrincipalPoint) {
  const Eigen::Vector4d expected(kRig.cx, kRig.cy, kRig.cx - kRig.fx * kRig.baseline / 4, kRig.cy);
  EXPECT_TRUE(test::agree(project(kRig, {0, 0, 4})->pixels, expected, 1e-15));
}

TEST(Stereo, TheRightCameraSeesAPointDisplacedByTheBaseline) {
  for (const Eigen::Vector3d& p : points()) {
    const Eigen::Vector4d pixels = project(kRig, p)->pixels;
    const Eigen::Vector3d p_cam1 = p - kRig.baseline * Eigen::Vector3d::UnitX();
    const Eigen::Vector4d other = project(kRig, p_cam1)->pixels;
    EXPECT_TRUE(test::agree(pixels.tail<2>(), other.head<2>(), 1e-14));
  }
}

TEST(Stereo, ProjectionJacobianIsTheDerivative) {
  for (const Eigen::Vector3d& p : points()) {
    const auto pixels = [](const Eigen::Vector3d& q) { return project(kRig, q)->pixels; };
    // The projection varies on the scale of the depth.
    const double step = 1e-3 * p.z() / std::max(1.0, p.norm());
    const Eigen::MatrixXd expected = test::numeric_derivative(pixels, p, step);
    EXPECT_TRUE(test::agree(project(kRig, p)->d_point, expected, 1e-9));
  }
}

TEST(Stereo, TriangulationInvertsProjection) {
  for (const Eigen::Vector3d& p : points()) {
    const Eigen::Vector4d pixels = project(kRig, p)->pixels;
    // The disparity is a difference of pixels: round-off grows with the depth.
    const double tolerance = 1e-12 * std::max(1.0, p.z());
    EXPECT_TRUE(test::agree(triangulate(kRig, pixels)->p_cam0, p, tolerance));
  }
}

TEST(Stereo, TriangulationAveragesTheTwoRows) {
  Eigen::Vector4d pixels = project(kRig, {1, 2, 10})->pixels;
  pixels[1] += 0.3;
  pixels[3] -= 0.3;
  EXPECT_TRUE(test::agree(triangulate(kRig, pixels)->p_cam0, Eigen::Vector3d(1, 2, 10), 1e-12));
}

TEST(Stereo, TriangulationJacobianIsTheDerivative) {
  for (const Eigen::Vector3d& p : points()) {
    const Eigen::Vector4d pixels = project(kRig, p)->pixels;
    const auto point = [](const Eigen::Vector4d& z) { return triangulate(kRig, z)->p_cam0; };
    const double disparity = pixels[0] - pixels[2];
    const Eigen::MatrixXd expected =
        test::numeric_derivative(point, pixels, 1e-3 * disparity / pixels.norm());
    EXPECT_TRUE(test::agree(triangulate(kRig, pixels)->d_pixels, expected, 1e-8));
  }
}

TEST(Stereo, TheTwoJacobiansAreInverseOnConsistentPixels) {
  for (const Eigen::Vector3d& p : points()) {
    const StereoProjection seen = *project(kRig, p);
    const Eigen::Matrix3d product = triangulate(kRig, seen.pixels)->d_pixels * seen.d_point;
    EXPECT_TRUE(test::agree(product, Eigen::Matrix3d::Identity(), 1e-12 * std::max(1.0, p.z())));
  }
}

TEST(Stereo, PointsBehindOrInTheImagePlaneAreNotSeen) {
  for (const double z : {-10.0, -1e-9, -0.0, 0.0, 0.5 * kMinDepth, kMinDepth, kNaN}) {
    EXPECT_FALSE(project(kRig, {1, 1, z}).has_value()) << z;
  }
  EXPECT_TRUE(project(kRig, {1, 1, 1.001 * kMinDepth}).has_value());
}

TEST(Stereo, PixelsWithoutPositiveDisparityMeanNoPoint) {
  for (const double disparity : {0.0, -1e-9, -190.0, kNaN}) {
    EXPECT_FALSE(triangulate(kRig, {600, 200, 600 - disparity, 200}).has_value()) << disparity;
  }
  EXPECT_FALSE(triangulate(kRig, {-1, -1, -1, -1}).has_value());
  EXPECT_TRUE(triangulate(kRig, {600, 200, 599.9, 200}).has_value());
}

}  // namespace
}  // namespace chasles
