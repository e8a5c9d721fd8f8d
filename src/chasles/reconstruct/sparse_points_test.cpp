#include <cmath>

#include <gtest/gtest.h>

#include <chasles/reconstruct/sparse_points.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Five poses along x of a body whose two cameras look along z, and what these show.
class Gallery : public ::testing::Test {
 public:
  Gallery() : images(5) {
    const Camera camera{.width = 640,
                        .height = 480,
                        .fx = 400,
                        .fy = 400,
                        .cx = 320,
                        .cy = 240,
                        .distortion = Distortion::kEquidistant,
                        .coefficients = {0.01, 0, 0, 0},
                        .cam_T_imu = {}};
    cameras = {camera, camera};
    cameras[1].cam_T_imu.p.x() = -0.2;
  }

  SE3 pose(std::size_t k) const { return {.p = {0.2 * static_cast<double>(k), 0, 0}}; }

  // Where the point is in an image.
  Vector2d pixel(const Vector3d& p_world, std::size_t k, std::size_t camera) const {
    return project(cameras[camera], cameras[camera].cam_T_imu * (pose(k).inverse() * p_world))
        .value()
        .pixel;
  }

  void show(LandmarkId track, std::size_t k, std::size_t camera, const Vector2d& at,
            std::uint8_t grey = 100) {
    images[k].pixels.push_back(
        {.track = track, .pixel = at, .camera = static_cast<std::uint8_t>(camera), .grey = grey});
  }

  SparsePoints points(const ColmapSettings& settings = {}) const {
    std::vector<PosedTracks> keyframes;
    for (std::size_t k = 0; k < images.size(); ++k) {
      keyframes.emplace_back().images = &images[k];
      keyframes.back().world_T_imu = pose(k);
    }
    return sparse_points(keyframes, cameras, settings);
  }

  std::vector<Camera> cameras;
  std::vector<TrackedImages> images;
};

TEST_F(Gallery, ATrackIsThePointThatItsImagesShow) {
  const Vector3d p(0.3, -0.2, 3);
  for (std::size_t k = 1; k < 5; ++k) show(7, k, 0, pixel(p, k, 0), static_cast<std::uint8_t>(k));
  show(7, 4, 1, pixel(p, 4, 1), 200);
  const SparsePoints found = points();
  ASSERT_EQ(found.points.size(), 1);
  EXPECT_LT((found.points[0].p_world - p).norm(), 1e-9);
  EXPECT_LT(found.points[0].error, 1e-8);
  EXPECT_EQ(found.points[0].grey, 42) << "the mean of 1, 2, 3, 4 and 200";
  ASSERT_EQ(found.observations.size(), 5);
  EXPECT_EQ(found.observations[0].keyframe, 1);
  EXPECT_EQ(found.observations[4].camera, 1);
  EXPECT_EQ(found.observations[4].pixel, pixel(p, 4, 1));
}

TEST_F(Gallery, TheErrorIsTheMeanLengthOfTheReprojectionErrors) {
  const Vector3d p(0.3, -0.2, 3);
  for (std::size_t k = 0; k < 5; ++k) {
    show(1, k, 0, pixel(p, k, 0) + Vector2d(0, k % 2 == 0 ? 0.6 : -0.6));
  }
  const SparsePoints found = points();
  ASSERT_EQ(found.points.size(), 1);
  double sum = 0;
  for (const auto& o : found.observations) {
    sum += (pixel(found.points[0].p_world, o.keyframe, 0) - o.pixel).norm();
  }
  EXPECT_NEAR(found.points[0].error, sum / 5, 1e-12);
  EXPECT_GT(found.points[0].error, 0.5);
  EXPECT_EQ(points({.max_error = 0.5}).too_wrong, 1);
}

TEST_F(Gallery, WhatIsNoPointIsCounted) {
  const Vector3d near(0.3, -0.2, 3), far(0, 0, 100);
  show(1, 0, 0, pixel(near, 0, 0));
  show(1, 1, 0, pixel(near, 1, 0));
  for (std::size_t k = 0; k < 5; ++k) {
    show(2, k, 0, pixel(far, k, 0));
    show(3, k, 0, pixel(near, k, 0) + Vector2d(0, k % 2 == 0 ? 5 : -5));
    // The rays diverge: the point would be behind the cameras.
    show(4, k, 0, pixel(near, 4 - k, 0));
  }
  const SparsePoints found = points();
  EXPECT_TRUE(found.points.empty());
  EXPECT_EQ(found.too_short, 1);
  EXPECT_EQ(found.too_uncertain, 2);
  EXPECT_EQ(found.too_wrong, 1);
}

// COLMAP's projections end at 90 degrees.
TEST_F(Gallery, ObservationsBesideTheCameraAreLeftOut) {
  const Vector3d p(1.5, 0, -0.1);
  for (std::size_t k = 0; k < 5; ++k) show(1, k, 0, pixel(p, k, 0));
  EXPECT_TRUE(points().points.empty());
  EXPECT_EQ(points().too_uncertain, 0) << "there is nothing to triangulate";
  const Vector3d q(1.5, 0, 0.2);
  for (std::size_t k = 0; k < 5; ++k) show(2, k, 0, pixel(q, k, 0));
  EXPECT_EQ(points().points.size(), 1);
}

}  // namespace
}  // namespace chasles
