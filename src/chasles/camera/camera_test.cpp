#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include <chasles/base/constants.hpp>
#include <chasles/camera/camera.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using test::euroc_camera;
using test::fisheye_camera;
using test::lenses;
using test::pinhole_camera;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Directions (x/z, y/z) on rings about the axis, on the axis and close to it.
std::vector<Eigen::Vector2d> directions(double largest_angle) {
  std::vector<Eigen::Vector2d> all = {{0, 0}};
  for (const double angle :
       {1e-300, 1e-12, 0.99e-9, 1.01e-9, 1e-6, 1e-3, 0.1, 0.5, 0.8, 1.0, 1.3}) {
    if (angle > largest_angle) break;
    for (int i = 0; i < 12; ++i) {
      const double around = 0.1 + i * std::numbers::pi / 6;
      all.emplace_back(std::tan(angle) * std::cos(around), std::tan(angle) * std::sin(around));
    }
  }
  return all;
}

// The formulas of OpenCV's documentation, term by term.
Eigen::Vector2d opencv_pixel(const Camera& camera, double x, double y) {
  const auto& k = camera.coefficients;
  const double r = std::sqrt(x * x + y * y);
  double xd = x;
  double yd = y;
  if (camera.distortion == Distortion::kRadtan) {
    const double radial =
        (1 + k[0] * std::pow(r, 2) + k[1] * std::pow(r, 4) + k[4] * std::pow(r, 6)) /
        (1 + k[5] * std::pow(r, 2) + k[6] * std::pow(r, 4) + k[7] * std::pow(r, 6));
    xd = x * radial + 2 * k[2] * x * y + k[3] * (r * r + 2 * x * x) + k[8] * std::pow(r, 2) +
         k[9] * std::pow(r, 4);
    yd = y * radial + k[2] * (r * r + 2 * y * y) + 2 * k[3] * x * y + k[10] * std::pow(r, 2) +
         k[11] * std::pow(r, 4);
  } else if (camera.distortion == Distortion::kEquidistant && r > 0) {
    const double theta = std::atan(r);
    const double theta_d = theta * (1 + k[0] * std::pow(theta, 2) + k[1] * std::pow(theta, 4) +
                                    k[2] * std::pow(theta, 6) + k[3] * std::pow(theta, 8));
    xd = theta_d / r * x;
    yd = theta_d / r * y;
  }
  return {camera.fx * xd + camera.cx, camera.fy * yd + camera.cy};
}

TEST(Camera, ProjectsAsOpenCvDocumentsIt) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    if (camera.distortion > Distortion::kEquidistant) continue;
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      for (const double z : {0.2, 3.0, 500.0}) {
        const auto seen = project(camera, {xy.x() * z, xy.y() * z, z});
        ASSERT_TRUE(seen);
        EXPECT_TRUE(test::agree(seen->pixel, opencv_pixel(camera, xy.x(), xy.y()), 1e-14));
      }
    }
  }
}

TEST(Camera, ProjectionJacobianIsTheDerivativeOnTheAxisAndOffIt) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      for (const double z : {0.2, 3.0, 50.0}) {
        const Eigen::Vector3d p(xy.x() * z, xy.y() * z, z);
        const auto pixel = [&](const Eigen::Vector3d& q) { return project(camera, q)->pixel; };
        const double step = 1e-3 * z / std::max(1.0, p.norm());
        const Eigen::MatrixXd expected = test::numeric_derivative(pixel, p, step);
        EXPECT_TRUE(test::agree(project(camera, p)->d_point, expected, 1e-8));
      }
    }
  }
}

TEST(Camera, UnprojectionInvertsProjectionOverTheWholeImage) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    int seen = 0;
    for (int v = 0; v < camera.height; v += 3) {
      for (int u = 0; u < camera.width; u += 3) {
        const Eigen::Vector2d pixel(u, v);
        const auto ray = unproject(camera, pixel);
        if (!ray) continue;
        ++seen;
        ASSERT_LT((project(camera, ray->ray)->pixel - pixel).norm(), 1e-10) << u << " " << v;
        ASSERT_EQ(ray->ray.z(), 1);
      }
    }
    const int all = ((camera.width + 2) / 3) * ((camera.height + 2) / 3);
    if (!sees_all) continue;
    EXPECT_EQ(seen, all) << name_of(camera.distortion);
  }
}

// A ray (x/z, y/z, 1) covers less than 90 degrees; the corners of a fisheye image lie beyond.
TEST(Camera, AFisheyePixelHasARayExactlyWhereItLooksForward) {
  const Camera camera = fisheye_camera();
  const auto& k = camera.coefficients;
  const double t = std::numbers::pi * std::numbers::pi / 4;
  const double radius = std::numbers::pi / 2 *
                        (1 + t * k[0] + t * t * k[1] + t * t * t * k[2] + t * t * t * t * k[3]);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double r = std::hypot((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      ASSERT_EQ(unproject(camera, Eigen::Vector2d(u, v)).has_value(), r < radius) << u << " " << v;
    }
  }
}

TEST(Camera, ProjectionInvertsUnprojection) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      const Eigen::Vector3d ray(xy.x(), xy.y(), 1);
      const auto back = unproject(camera, project(camera, ray)->pixel);
      ASSERT_TRUE(back);
      EXPECT_TRUE(test::agree(back->ray, ray, 1e-12));
    }
  }
}

TEST(Camera, TheTwoJacobiansAreInverse) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      const auto seen = project(camera, {xy.x(), xy.y(), 1});
      const auto back = unproject(camera, seen->pixel);
      const Eigen::Matrix2d product = seen->d_point.leftCols<2>() * back->d_pixel;
      EXPECT_TRUE(test::agree(product, Eigen::Matrix2d::Identity(), 1e-11));
    }
  }
}

TEST(Camera, UnprojectionJacobianIsTheDerivative) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      const Eigen::Vector2d pixel = project(camera, {xy.x(), xy.y(), 1})->pixel;
      const auto ray = [&](const Eigen::Vector2d& q) { return unproject(camera, q)->ray; };
      const Eigen::MatrixXd expected = test::numeric_derivative(ray, pixel, 1e-4);
      EXPECT_TRUE(
          test::agree(1e3 * unproject(camera, pixel)->d_pixel, 1e3 * expected.topRows<2>(), 1e-8));
    }
  }
}

TEST(Camera, PointsBehindOrTooNearOrNotFiniteAreNotSeen) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const double z : {-1e-9, 0.0, 0.5 * kMinDepth, kNaN, kInfinity}) {
      EXPECT_FALSE(project(camera, {0.01, 0.01, z})) << z;
    }
    for (const double z : {-0.3, -1e-9, 0.0, kMinDepth}) {
      const bool wide = test::widest_angle(camera) > std::atan2(1.0, z);
      EXPECT_EQ(project(camera, {0, 1, z}).has_value(), wide) << z;
    }
    EXPECT_FALSE(project(camera, {0, 0, -10}));
    EXPECT_FALSE(project(camera, {kNaN, 0, 1}));
    EXPECT_FALSE(project(camera, {0, -kInfinity, 1}));
    EXPECT_TRUE(project(camera, {0.01, 0.01, 1.001 * kMinDepth}));
    EXPECT_FALSE(unproject(camera, {kNaN, 1}));
    EXPECT_FALSE(unproject(camera, {1, kInfinity}));
  }
}

// Unit vectors on both sides of 90 degrees, where the lens has them.
std::vector<Eigen::Vector3d> wide_directions(const Camera& camera) {
  std::vector<Eigen::Vector3d> all;
  for (const double angle : {1.45, std::numbers::pi / 2, 1.6, 1.75, 1.9}) {
    if (angle > test::widest_angle(camera)) break;
    for (int i = 0; i < 12; ++i) {
      const double around = 0.1 + i * std::numbers::pi / 6;
      all.emplace_back(std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around),
                       std::cos(angle));
    }
  }
  return all;
}

TEST(Camera, ADirectionBeyond90DegreesHasAPixelAndComesBack) {
  int wide = 0;
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    for (const Eigen::Vector3d& direction : wide_directions(camera)) {
      ++wide;
      const auto pixel = [&](const Eigen::Vector3d& q) { return project(camera, q)->pixel; };
      for (const double distance : {0.2, 3.0, 50.0}) {
        const auto seen = project(camera, distance * direction);
        ASSERT_TRUE(seen) << name_of(camera.distortion);
        EXPECT_TRUE(test::agree(
            seen->d_point,
            test::numeric_derivative(pixel, Eigen::Vector3d(distance * direction), 1e-4 * distance),
            1e-8));
        const auto back = bearing(camera, seen->pixel);
        ASSERT_TRUE(back);
        EXPECT_LT((back->bearing - direction).norm(), 1e-12);
      }
      EXPECT_FALSE(project(camera, kMinDepth * 0.99 * direction));
    }
  }
  EXPECT_GT(wide, 500);
}

TEST(Camera, TheJacobianOfABearingIsTheDerivative) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    std::vector<Eigen::Vector3d> all = wide_directions(camera);
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      all.emplace_back(xy.x(), xy.y(), 1);
    }
    for (const Eigen::Vector3d& direction : all) {
      const Eigen::Vector2d pixel = project(camera, direction)->pixel;
      const auto at = [&](const Eigen::Vector2d& q) { return bearing(camera, q)->bearing; };
      const Eigen::MatrixXd expected = test::numeric_derivative(at, pixel, 1e-3);
      EXPECT_TRUE(test::agree(1e3 * bearing(camera, pixel)->d_pixel, 1e3 * expected, 1e-6));
      EXPECT_LT((at(pixel) - direction.normalized()).norm(), 1e-12);
    }
  }
  EXPECT_FALSE(bearing(fisheye_camera(), {kNaN, 1}));
  EXPECT_FALSE(bearing(fisheye_camera(), {1, kInfinity}));
  EXPECT_FALSE(bearing(fisheye_camera(), {1e5, 1}));
}

TEST(Camera, TheDerivativeByItsParametersIsTheDerivative) {
  for (const auto& [camera, largest_angle, sees_all] : lenses()) {
    std::vector<Eigen::Vector3d> points = wide_directions(camera);
    for (const Eigen::Vector2d& xy : directions(largest_angle)) {
      points.emplace_back(3 * xy.x(), 3 * xy.y(), 3);
    }
    Eigen::VectorXd parameters(4 + static_cast<int>(camera.coefficients.size()));
    parameters.head<4>() << camera.fx, camera.fy, camera.cx, camera.cy;
    for (std::size_t i = 0; i < camera.coefficients.size(); ++i) {
      parameters[4 + static_cast<int>(i)] = camera.coefficients[i];
    }
    for (const Eigen::Vector3d& p : points) {
      const auto pixel = [&](const Eigen::VectorXd& at) {
        Camera moved = camera;
        moved.fx = at[0], moved.fy = at[1], moved.cx = at[2], moved.cy = at[3];
        for (std::size_t i = 0; i < moved.coefficients.size(); ++i) {
          moved.coefficients[i] = at[4 + static_cast<int>(i)];
        }
        return project(moved, p)->pixel;
      };
      const auto d = parameter_derivative(camera, p);
      ASSERT_TRUE(d);
      EXPECT_TRUE(test::agree(*d, test::numeric_derivative(pixel, parameters, 1e-6), 1e-7, 1e-6))
          << name_of(camera.distortion) << " " << p.transpose();
    }
    EXPECT_FALSE(parameter_derivative(camera, {0, 0, -1}));
  }
}

// projectaria-tools 2.3.0, KANNALA_BRANDT_K3, 95 degrees from the axis: its jacobian_wrt_params.
TEST(Camera, TheDerivativeByItsParametersIsThatOfAnotherProgram) {
  constexpr double kDegree = std::numbers::pi / 180;
  const Eigen::Vector3d p(std::sin(95 * kDegree) * std::cos(200 * kDegree),
                          std::sin(95 * kDegree) * std::sin(200 * kDegree), std::cos(95 * kDegree));
  Eigen::Matrix<double, 2, 8> expected;
  expected << -1.5329966152437526, 0, 1, 0, -818.0374025449086, -2248.9256967415663,
      -6182.684035876813, -16997.263156746554,  //
      0, -0.5579651371795638, 0, 1, -297.7331937081867, -818.5198232015034, -2250.2519542059317,
      -6186.330146045893;
  EXPECT_TRUE(test::agree(*parameter_derivative(fisheye_camera(), p), expected, 1e-13));
}

// 1 + 3 k1 r^2 + 5 k2 r^4 = (1 - r^2 / 1.44) (1 - r^2 / 9): falls from r = 1.2 to r = 3.
TEST(Camera, ARadtanLensIsNotUsedBeyondItsFold) {
  Camera camera = euroc_camera();
  camera.coefficients = {-(1 / 1.44 + 1.0 / 9) / 3, 1 / (1.44 * 9 * 5), 0, 0};
  EXPECT_TRUE(project(camera, {0, 1.2 - 1e-9, 1}));
  for (const double r : {1.2 + 1e-9, 1.5, 2.9, 3.1, 6.0}) EXPECT_FALSE(project(camera, {r, 0, 1}));
  const Eigen::Vector2d last = project(camera, {0, 1.2 - 1e-9, 1})->pixel;
  EXPECT_TRUE(unproject(camera, last - Eigen::Vector2d(0, 1e-6)));
  EXPECT_NEAR(unproject(camera, last - Eigen::Vector2d(0, 1))->ray.y(), 1.2, 0.1);
  EXPECT_FALSE(unproject(camera, last + Eigen::Vector2d(0, 1e-6)));
  EXPECT_FALSE(unproject(camera, last + Eigen::Vector2d(0, 1000)));
}

// 1 + 3 k1 r^2 + 5 k2 r^4 + 7 k3 r^6 = 1 - r^6 / 1.2^6: the fifth coefficient alone folds.
TEST(Camera, AFifthCoefficientFoldsARadtanLensToo) {
  Camera camera = euroc_camera();
  camera.coefficients = {0, 0, 0, 0, -1 / (7 * std::pow(1.2, 6))};
  EXPECT_TRUE(project(camera, {0, 1.2 - 1e-9, 1}));
  for (const double r : {1.2 + 1e-9, 1.5, 6.0}) EXPECT_FALSE(project(camera, {r, 0, 1}));
  EXPECT_FALSE(
      unproject(camera, project(camera, {0, 1.2 - 1e-9, 1})->pixel + Eigen::Vector2d(0, 1)));
}

// The same with theta for r: d theta_d / d theta = (1 - theta^2) (1 - theta^2 / 1.69).
TEST(Camera, AnEquidistantLensIsNotUsedBeyondItsFold) {
  Camera camera = fisheye_camera();
  camera.coefficients = {-(1 + 1 / 1.69) / 3, 1 / (5 * 1.69), 0, 0};
  EXPECT_TRUE(project(camera, {std::tan(1 - 1e-9), 0, 1}));
  for (const double theta : {1 + 1e-9, 1.2, 1.4, 1.5}) {
    EXPECT_FALSE(project(camera, {0, std::tan(theta), 1})) << theta;
  }
  const Eigen::Vector2d last = project(camera, {0, -std::tan(1 - 1e-9), 1})->pixel;
  EXPECT_TRUE(unproject(camera, last + Eigen::Vector2d(0, 1e-6)));
  EXPECT_FALSE(unproject(camera, last - Eigen::Vector2d(0, 1e-6)));
  EXPECT_FALSE(unproject(camera, last - Eigen::Vector2d(0, 30)));
}

TEST(Camera, TheImageEndsAtItsLastPixel) {
  const Camera camera = euroc_camera();
  EXPECT_TRUE(in_image(camera, {0, 0}));
  EXPECT_TRUE(in_image(camera, {751, 479}));
  for (const Eigen::Vector2d& pixel : std::vector<Eigen::Vector2d>{
           {-0.01, 5}, {5, -0.01}, {751.01, 5}, {5, 479.01}, {kNaN, 5}, {5, kNaN}}) {
    EXPECT_FALSE(in_image(camera, pixel)) << pixel.transpose();
  }
  EXPECT_TRUE(in_image(camera, {10, 469}, 10));
  EXPECT_FALSE(in_image(camera, {9.9, 469}, 10));
  EXPECT_FALSE(in_image(camera, {10, 469.1}, 10));
}

}  // namespace
}  // namespace chasles
