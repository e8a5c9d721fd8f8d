#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/loop/appearance.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Looks along the map's x axis.
Matrix3d level_camera() {
  Matrix3d map_R_cam;
  map_R_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return map_R_cam;
}

TEST(ViewPatches, TheirPixelsHaveTheSameSizeAtThePointFromAnyDistance) {
  const Camera camera = test::pinhole_camera();
  for (const double distance : {1.0, 2.7, 9.0, 31.0}) {
    const auto found = view_patches(camera, level_camera(), Vector3d(0, 0, distance));
    ASSERT_TRUE(found);
    for (int i = 0; i < PatchView::kLevels; ++i) {
      const double pixel = 1e-3 * std::exp2((found->view.level + i) / 2.0);  // [m]
      const auto& step = found->patches[static_cast<std::size_t>(i)].step;
      EXPECT_NEAR(step(0, 0), camera.fx * pixel / distance, 1e-9);
      EXPECT_NEAR(step(1, 1), camera.fy * pixel / distance, 1e-9);
    }
    // The finest patch has about the image's pixels.
    EXPECT_NEAR(found->patches[0].step.determinant(), 1, 0.45) << distance;
  }
}

TEST(ViewPatches, AreUprightHoweverTheCameraIsTurned) {
  const Camera camera = test::euroc_camera();
  test::Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Matrix3d map_R_cam = so3::exp(Vector3d(0, 0, random.uniform(-3, 3))) * level_camera() *
                               so3::exp(Vector3d(0, 0, random.uniform(-3, 3)));
    const Vector3d p_cam(random.uniform(-1, 1), random.uniform(-0.6, 0.6), 2);
    const auto found = view_patches(camera, map_R_cam, p_cam);
    ASSERT_TRUE(found);
    // A step down on the patch is a step towards the ground, across the ray.
    const auto seen = project(camera, p_cam).value();
    const Vector3d ray = p_cam.normalized(), up = map_R_cam.row(2).transpose();
    const Vector3d down = -(up - up.dot(ray) * ray).normalized();
    const Eigen::Vector2d expected = (seen.d_point * down).normalized();
    EXPECT_TRUE(
        test::agree(Eigen::Vector2d(found->patches[0].step.col(1).normalized()), expected, 1e-12));
    EXPECT_GT(found->patches[0].step.determinant(), 0) << "mirrored";
    EXPECT_TRUE(test::agree(Vector3d(-found->view.from.cast<double>()), map_R_cam * ray, 1e-6));
  }
}

TEST(ViewPatches, StraightDownTheyKeepTheAxesOfTheMap) {
  Matrix3d map_R_cam;
  map_R_cam << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const auto found = view_patches(test::pinhole_camera(), map_R_cam, Vector3d(0, 0, 5));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->patches[0].step.allFinite());
  EXPECT_LT(found->patches[0].step.col(1).x(), 0) << "down on the patch is against the x axis";
}

TEST(ViewPatches, APointBehindTheCameraHasNone) {
  EXPECT_FALSE(view_patches(test::pinhole_camera(), level_camera(), Vector3d(0, 0, -5)));
}

PatchView view(const Vector3d& from, int level, std::uint64_t bits) {
  PatchView v{.from = from.normalized().cast<float>(), .level = level, .descriptors = {}};
  // The descriptor of each size has its own bits.
  for (int i = 0; i < PatchView::kLevels; ++i) {
    v.descriptors[static_cast<std::size_t>(i)][static_cast<std::size_t>(level + i) % 4] = bits;
  }
  return v;
}

TEST(Appearance, ComparesDescriptorsOfOneSize) {
  const Vector3d front(1, 0, 0);
  EXPECT_EQ(distance(view(front, 4, 7), view(front, 4, 7)), 0);
  EXPECT_EQ(distance(view(front, 4, 7), view(front, 6, 5)), 1) << "seen from twice the distance";
  EXPECT_EQ(distance(view(front, 4, 7), view(front, 7, 7)), std::nullopt);
  Appearance appearance;
  EXPECT_EQ(appearance.distance(view(front, 4, 7)), std::nullopt);
  appearance.add(view(front, 4, 7));
  EXPECT_EQ(appearance.distance(view(front, 5, 7)), 0);
  EXPECT_EQ(appearance.distance(view({0.5, 0.2, 0}, 4, 7)), 0);
  EXPECT_EQ(appearance.distance(view({-1, 0, 0}, 4, 7)), std::nullopt) << "from behind";
  EXPECT_TRUE(appearance.may_match(view({1, 0.3, 0}, 2, 0)));
  EXPECT_FALSE(appearance.may_match(view({1, 0.3, 0}, 1, 0)));
  EXPECT_FALSE(appearance.may_match(view({0, 1, 0}, 4, 0)));
}

TEST(Appearance, KeepsFewViewsThatDiffer) {
  Appearance appearance;
  for (int i = 0; i < 100; ++i) appearance.add(view({1, 0.001 * i, 0}, 4, 7));
  EXPECT_EQ(appearance.views().size(), 1u);
  for (int i = 0; i < 100; ++i) appearance.add(view({std::cos(i), std::sin(i), 0}, 4, 7));
  EXPECT_EQ(appearance.views().size(), Appearance::kMostViews);
}

}  // namespace
}  // namespace chasles
