#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/LU>

#include <chasles/camera/anchor_face.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(AnchorFace, EachFaceLooksTowardsItsDirections) {
  test::Random random(5);
  std::set<AnchorFace> met;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d direction = random.axis();
    const AnchorFace face = face_towards(direction);
    met.insert(face);
    const Eigen::Matrix3d R = face_R_cam(face);
    EXPECT_EQ(R * R.transpose(), Eigen::Matrix3d::Identity());
    EXPECT_EQ(R.determinant(), 1);
    const double angle = std::acos(direction.z());
    EXPECT_EQ(face == AnchorFace::kFront, angle < 80 * kDegree) << angle;
    if (face != AnchorFace::kFront) {
      EXPECT_GT((R * direction).z(), std::cos(55 * kDegree)) << direction.transpose();
    }
  }
  EXPECT_EQ(met.size(), static_cast<std::size_t>(kAnchorFaces));
}

TEST(AnchorFace, ItsInverseDepthIsThatOfThePointInItsAxes) {
  test::Random random(6);
  const SE3 cam_T_imu{so3::exp(random.normal_vector(3)), random.normal_vector(3)};
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p_imu = 4 * random.normal_vector(3), p_cam = cam_T_imu * p_imu;
    const AnchorFace face = face_towards(p_cam);
    const Eigen::Vector3d p_face = face_T_imu(face, cam_T_imu) * p_imu;
    const Eigen::Vector3d a = inverse_depth_in(face, 2 * p_cam, 2);
    EXPECT_TRUE(test::agree(Eigen::Vector3d(a.x(), a.y(), 1) / a.z(), p_face, 1e-13));
  }
  const SE3 front = face_T_imu(AnchorFace::kFront, cam_T_imu);
  EXPECT_EQ(front.R, cam_T_imu.R);
  EXPECT_EQ(front.p, cam_T_imu.p);
}

TEST(AnchorFace, APixelsRayIsThatOfTheLensInItsAxes) {
  int beside = 0;
  for (const auto& [camera, largest_angle, sees_all] : test::lenses()) {
    for (const double angle : {0.0, 0.5, 1.2, 1.45, 1.6, 1.9}) {
      if (angle > std::max(largest_angle, test::widest_angle(camera))) break;
      for (const double around : {0.2, 1.1, 2.5, 4.0, 5.5}) {
        const Eigen::Vector3d b(std::sin(angle) * std::cos(around),
                                std::sin(angle) * std::sin(around), std::cos(angle));
        const Eigen::Vector2d pixel = project(camera, b)->pixel;
        const auto ray = face_ray(camera, pixel);
        ASSERT_TRUE(ray);
        EXPECT_EQ(ray->face, face_towards(b));
        beside += ray->face != AnchorFace::kFront;
        const Eigen::Vector3d in_face = face_R_cam(ray->face) * b;
        EXPECT_TRUE(test::agree(ray->xy, in_face.head<2>() / in_face.z(), 1e-11));
        const auto xy = [&](const Eigen::Vector2d& q) {
          const Eigen::Vector3d p = face_R_cam(ray->face) * bearing(camera, q)->bearing;
          return Eigen::Vector2d(p.head<2>() / p.z());
        };
        EXPECT_TRUE(
            test::agree(1e3 * ray->d_pixel, 1e3 * test::numeric_derivative(xy, pixel, 1e-4), 1e-7));
        const auto forward = unproject(camera, pixel);
        if (!forward || ray->face != AnchorFace::kFront) continue;
        // The same digits as without faces.
        EXPECT_EQ(ray->xy, forward->ray.head<2>());
        EXPECT_EQ(ray->d_pixel, forward->d_pixel);
      }
    }
  }
  EXPECT_GT(beside, 50);
  EXPECT_FALSE(face_ray(test::fisheye_camera(), {1e5, 0}));
}

}  // namespace
}  // namespace chasles
