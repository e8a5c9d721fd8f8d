#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/sim/render.hpp>
#include <chasles/sim/render_testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::chess_room;
using test::forward_camera;
using test::looking;

constexpr double kField = 0.25;  // [m], of the chessboard

std::vector<float> rendered(const PaintedWorld& world, const Camera& camera,
                            const SE3& world_T_imu) {
  const SE3 world_T_cam = world_T_imu * camera.cam_T_imu.inverse();
  std::vector<float> light(static_cast<std::size_t>(camera.width * camera.height)), some;
  for (const RayFace& face : make_faces(camera)) {
    render(world, face.rays, {world_T_cam.R * face.cam_R_face, world_T_cam.p}, some);
    for (const std::size_t pixel : face.pixels) light[pixel] = some[pixel];
  }
  return light;
}

float between_pixels(const std::vector<float>& light, const Camera& camera, double u, double v) {
  const auto i = static_cast<int>(u), j = static_cast<int>(v);
  const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
  const float* p = light.data() + static_cast<std::size_t>(j * camera.width + i);
  const float* q = p + camera.width;
  return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1]);
}

// The saddle of the parabola that best fits the shades about a point, iterated until it is that
// point.
std::optional<Vector2d> saddle(const std::vector<float>& light, const Camera& camera,
                               const Vector2d& about) {
  constexpr int kReach = 3;
  Vector2d at = about + Vector2d(0.4, -0.3);  // away from the solution
  for (int iteration = 0; iteration < 15; ++iteration) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (int v = -kReach; v <= kReach; ++v) {
      for (int u = -kReach; u <= kReach; ++u) {
        const double x = u, y = v;
        const Eigen::Matrix<double, 6, 1> row{x * x, x * y, y * y, x, y, 1};
        A += row * row.transpose();
        b += row * static_cast<double>(between_pixels(light, camera, at.x() + x, at.y() + y));
      }
    }
    const Eigen::Matrix<double, 6, 1> c = A.ldlt().solve(b);
    Eigen::Matrix2d H;
    H << 2 * c[0], c[1], c[1], 2 * c[2];
    if (H.determinant() >= 0) return std::nullopt;
    at -= H.inverse() * Vector2d(c[3], c[4]);
    if ((at - about).norm() > 3) return std::nullopt;
  }
  return at;
}

// Root mean square and largest distance of the chessboard's corners from their projections.
struct CornerErrors {
  double rms = 0, worst = 0;
  int count = 0, beside = 0;  // beside: beyond 90 degrees
};

CornerErrors corner_errors(const PaintedWorld& painted, const Camera& camera, const SE3& pose,
                           double least_depth = 0.5) {
  const std::vector<float> light = rendered(painted, camera, pose);
  CornerErrors errors;
  for (const Surface& s : painted.surfaces) {
    const Vector3d right = s.right.normalized(), down = s.down.normalized();
    for (int i = 1; i * kField < s.right.norm() - 0.1; ++i) {
      for (int j = 1; j * kField < s.down.norm() - 0.1; ++j) {
        const Vector3d p =
            camera.cam_T_imu * (pose.inverse() * (s.corner + kField * (i * right + j * down)));
        // Fields that appear large enough and not too oblique.
        const Vector3d normal = camera.cam_T_imu.R * pose.R.transpose() * right.cross(down);
        if (p.z() < least_depth || p.norm() > 3.2 || normal.dot(p.normalized()) < 0.7) continue;
        const auto projection = project(camera, p);
        if (!projection || !in_image(camera, projection->pixel, 8)) continue;
        const auto found = saddle(light, camera, projection->pixel);
        if (!found) {
          ADD_FAILURE() << "no corner at " << projection->pixel.transpose();
          continue;
        }
        const double error = (*found - projection->pixel).norm();
        errors.rms += error * error;
        errors.worst = std::max(errors.worst, error);
        ++errors.count;
        errors.beside += p.z() < 0 ? 1 : 0;
      }
    }
  }
  errors.rms = std::sqrt(errors.rms / std::max(1, errors.count));
  return errors;
}

Camera with_lens(Distortion distortion) {
  Camera camera = forward_camera(376, 240, 260);
  camera.distortion = distortion;
  if (distortion == Distortion::kRadtan) camera.coefficients = {-0.28, 0.074, 2e-4, -3e-4};
  return camera;
}

TEST(Render, CornersLieWhereTheyProjectThroughEveryLens) {
  const PaintedWorld room = paint_world(chess_room(), 0.0025, 1);
  for (const test::Lens& lens : test::lenses()) {
    Camera camera = forward_camera(376, 240, 260);
    camera.distortion = lens.camera.distortion;
    camera.coefficients = lens.camera.coefficients;
    camera.fx = camera.fy = 320 * camera.fx / focal_lengths_at_axis(camera).x();
    CornerErrors all;
    for (const double yaw : {0.0, 0.7, 2.1, -1.4}) {
      const SE3 pose = looking(yaw, 0.1 * yaw, 0.2 - 0.1 * yaw, {0.4 * yaw, 0.3, -0.1 * yaw});
      const CornerErrors errors = corner_errors(room, camera, pose);
      EXPECT_LT(errors.rms, 0.04) << name_of(camera.distortion);
      EXPECT_LT(errors.worst, 0.1) << name_of(camera.distortion);
      all.count += errors.count;
    }
    EXPECT_GT(all.count, 100);
  }
}

TEST(Render, ASecondCameraSeesTheWallShiftedByItsDisparity) {
  const PaintedWorld world =
      paint_world(furnished({.rooms = {{{-3, -3}, {3, 3}}}}, -1.5, 1.5, {}), 0.004, 3);
  const Camera camera = forward_camera(320, 240, 400);
  const double depth = 2, baseline = 0.1;
  const auto shift = static_cast<std::size_t>(400 * baseline / depth);
  const auto left = rendered(world, camera, {Eigen::Matrix3d::Identity(), {3 - depth, 0, 0}});
  const auto right =
      rendered(world, camera, {Eigen::Matrix3d::Identity(), {3 - depth, -baseline, 0}});
  for (std::size_t v = 20; v < 220; ++v) {
    for (std::size_t u = 20; u + shift < 300; ++u) {
      ASSERT_NEAR(right[v * 320 + u], left[v * 320 + u + shift], 0.6) << u << " " << v;
    }
  }
}

// The nearest surface, by intersecting all surfaces one by one in double precision. `ambiguous`:
// the ray passes within about a hundredth of a degree of an edge.
struct Met {
  int surface = -1;
  bool ambiguous = false;
};

Met brute_force(const std::vector<Surface>& surfaces, const Vector3d& eye, const Vector3d& ray) {
  Met met;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& s = surfaces[i];
    const Vector3d away = s.right.cross(s.down);
    const double steep = away.dot(ray);
    if (steep <= 0) continue;
    const double depth = away.dot(s.corner - eye) / steep;
    if (depth <= 0) continue;
    const Vector3d p = eye + depth * ray - s.corner;
    const double u = p.dot(s.right.normalized()), v = p.dot(s.down.normalized());
    const double edge = std::max({-u, -v, u - s.right.norm(), v - s.down.norm()});
    if (std::abs(edge) < 5e-4 * (1 + depth) && depth < nearest + 1e-3) met.ambiguous = true;
    if (edge > 0 || depth >= nearest) continue;
    nearest = depth;
    met.surface = static_cast<int>(i);
  }
  return met;
}

TEST(Render, EveryRayMeetsTheNearestSurfaceAndNoneIsLost) {
  const InertialScene scene = inertial_scene("walk");
  const RenderWorld world = make_render_world(scene.settings, {});
  const PaintedWorld painted = paint_world(world, 0.02, 1);
  Camera camera = with_lens(Distortion::kRadtan);
  camera = {.width = 188,
            .height = 120,
            .fx = 115,
            .fy = 115,
            .cx = 92,
            .cy = 62,
            .distortion = camera.distortion,
            .coefficients = camera.coefficients,
            .cam_T_imu = camera.cam_T_imu};
  const RayTable rays = make_rays(camera);
  int compared = 0, wrong = 0;
  for (int k = 0; k < 8; ++k) {
    // In the hall, where the furniture is, and in the passages.
    const SE3 pose = looking(0.9 * k, 0.1 * std::sin(k), 0.2, {1.5 * k, 0.3 * std::cos(k), 0});
    const SE3 world_T_cam = pose * camera.cam_T_imu.inverse();
    const std::vector<int> seen = visible_surfaces(painted, rays, world_T_cam);
    for (std::size_t i = 0; i < seen.size(); i += 3) {
      const Vector3d ray = world_T_cam.R * Vector3d(static_cast<double>(rays.x[i]),
                                                    static_cast<double>(rays.y[i]), 1);
      const Met expected = brute_force(world.surfaces, world_T_cam.p, ray);
      ASSERT_GE(seen[i], 0) << "a hole at pixel " << i << " of view " << k;
      if (expected.ambiguous) continue;
      ++compared;
      wrong += seen[i] == expected.surface ? 0 : 1;
    }
  }
  EXPECT_GT(compared, 40000);
  EXPECT_EQ(wrong, 0);
}

TEST(Render, ABoxHidesWhatIsBehindIt) {
  const RenderWorld world = chess_room({Box{{0.5, -0.3, -0.4}, {1, 0.3, 0.4}}});
  const PaintedWorld painted = paint_world(world, 0.02, 1);
  const Camera camera = forward_camera(320, 240, 200);
  const RayTable rays = make_rays(camera);
  const SE3 pose{Eigen::Matrix3d::Identity(), {-1.5, 0, 0}};
  const auto seen = visible_surfaces(painted, rays, pose * camera.cam_T_imu.inverse());
  const auto at = [&](const Vector3d& p_world) {
    const auto pixel = project(camera, camera.cam_T_imu * (pose.inverse() * p_world))->pixel;
    return seen[rays.at(static_cast<int>(std::lround(pixel.x())),
                        static_cast<int>(std::lround(pixel.y())))];
  };
  const int front = at({0.5, 0, 0}), wall = at({3, 1.2, 0});
  EXPECT_NE(front, wall);
  EXPECT_EQ(at({0.5, 0.28, -0.38}), front);
  EXPECT_EQ(at({0.5, -0.28, 0.38}), front);
  EXPECT_EQ(at({3, 0.1, 0.1}), front) << "the wall is seen through the box";
  // 2 m to the face, 4.5 m to the wall: just beside the face.
  EXPECT_EQ(at({3, 0.32 * 4.5 / 2, 0}), wall);
}

// The image of a sensor with pixels of a fifth of the size, averaged five by five.
TEST(Render, AnImageIsTheMeanOfAFinerOne) {
  InertialSettings settings = inertial_scene("walk").settings;
  settings.hall_length = settings.hall_width = 9;
  const PaintedWorld world = paint_world(make_render_world(settings, {}), 0.006, 1);
  constexpr int kFiner = 5;
  Camera coarse = forward_camera(160, 120, 100);
  Camera fine = coarse;
  fine.width *= kFiner, fine.height *= kFiner, fine.fx *= kFiner, fine.fy *= kFiner;
  fine.cx = (coarse.cx + 0.5) * kFiner - 0.5;
  fine.cy = (coarse.cy + 0.5) * kFiner - 0.5;
  const SE3 pose = looking(0.3, 0.05, 0.1, {1, 0.2, 0});
  const auto image = rendered(world, coarse, pose), large = rendered(world, fine, pose);
  double square = 0, variation = 0, mean = 0;
  for (const float shade : image)
    mean += static_cast<double>(shade) / static_cast<double>(image.size());
  for (int v = 0; v < coarse.height; ++v) {
    for (int u = 0; u < coarse.width; ++u) {
      double sum = 0;
      for (int k = 0; k < kFiner * kFiner; ++k) {
        const int x = u * kFiner + k % kFiner, y = v * kFiner + k / kFiner;
        sum += static_cast<double>(large[static_cast<std::size_t>(y * fine.width + x)]);
      }
      const auto shade = static_cast<double>(image[static_cast<std::size_t>(v * coarse.width + u)]);
      square += std::pow(sum / (kFiner * kFiner) - shade, 2);
      variation += std::pow(shade - mean, 2);
    }
  }
  EXPECT_LT(square / variation, 0.03);
  EXPECT_LT(std::sqrt(square / static_cast<double>(image.size())), 7);
}

TEST(Render, TheSameViewGivesTheSameBytes) {
  const PaintedWorld one = paint_world(chess_room(), 0.02, 1),
                     other = paint_world(chess_room(), 0.02, 1);
  const Camera camera = with_lens(Distortion::kRadtan);
  const SE3 pose = looking(0.5, 0.1, 0, {0, 0, 0});
  EXPECT_EQ(rendered(one, camera, pose), rendered(other, camera, pose));
}

// Without lamps the light is the same everywhere along a wall.
TEST(Render, TexturesRepeatAfterTheirPeriod) {
  RenderWorld world;
  world.ceiling = 2.5;
  for (const double y : {1.0, 20.0}) {
    world.surfaces.push_back({.corner = {0, y, 2.5}, .right = {6, 0, 0}, .down = {0, 0, -2.5}});
  }
  const PaintedWorld painted = paint_world(world, 0.02, 1, {.period = 1.5}),
                     plain = paint_world(world, 0.02, 1);
  const auto pixel = [](const PaintedWorld& of, std::size_t wall, int x, int y) {
    const MipLevel& level = of.textures[wall].levels.front();
    return level
        .pixels[static_cast<std::size_t>(y + 1) * level.stride + static_cast<std::size_t>(x + 1)];
  };
  ASSERT_EQ(painted.texel, 0.02);
  int same = 0, count = 0;
  for (int y = 0; y < 120; y += 7) {
    for (int x = 0; x < 220; ++x) {
      EXPECT_EQ(pixel(painted, 0, x, y), pixel(painted, 0, x + 75, y));
      EXPECT_EQ(pixel(painted, 0, x, y), pixel(painted, 1, x, y));
      same += pixel(plain, 0, x, y) == pixel(plain, 0, x + 75, y);
      ++count;
    }
  }
  EXPECT_LT(same, count / 2);
}

// The part of the first surface's texels that are the same in both.
double same_part(const PaintedWorld& a, const PaintedWorld& b) {
  const MipLevel &p = a.textures[0].levels.front(), &q = b.textures[0].levels.front();
  int same = 0;
  for (std::size_t i = 0; i < p.pixels.size(); ++i) same += p.pixels[i] == q.pixels[i];
  return same / static_cast<double>(p.pixels.size());
}

TEST(Render, APartOfABuildingChanges) {
  RenderWorld world;
  world.ceiling = 2.5;
  world.surfaces.push_back({.corner = {0, 1, 2.5}, .right = {100, 0, 0}, .down = {0, 0, -2.5}});
  const auto with = [&](double changed) {
    return paint_world(world, 0.02, 1, {.changed = changed});
  };
  const PaintedWorld whole = with(0), half = with(0.5), all = with(1);
  const double by_chance = same_part(whole, all);
  EXPECT_LT(by_chance, 0.1);
  EXPECT_NEAR(same_part(whole, half), (1 + by_chance) / 2, 0.15);
  EXPECT_NEAR(same_part(whole, half) + same_part(all, half), 1 + by_chance, 1e-3)
      << "every strip is one of two pictures";
  EXPECT_EQ(same_part(half, with(0.5)), 1);
}

TEST(Render, ALensWithoutARayForAPixelIsRejected) {
  Camera camera = forward_camera(752, 480, 200);
  camera.distortion = Distortion::kRadtan;
  camera.coefficients = {-0.9, 0, 0, 0};
  try {
    make_rays(camera);
    FAIL() << "expected a UsageError";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("has no ray"), std::string::npos) << error.what();
  }
}

Camera fisheye(int width, int height, double focal_length) {
  Camera camera = forward_camera(width, height, focal_length);
  camera.distortion = Distortion::kEquidistant;
  camera.coefficients = {0, 0, 0, 0};
  return camera;
}

TEST(Render, EachPixelOfAFisheyeOfMoreThan180DegreesHasOneFace) {
  const Camera camera = fisheye(752, 480, 100);  // the circle: 314 px; the corner is outside
  const std::vector<RayFace> faces = make_faces(camera);
  EXPECT_EQ(faces.size(), 6u);
  std::vector<int> times(752 * 480, 0);
  for (const RayFace& face : faces) {
    for (const std::size_t i : face.pixels) {
      ++times[i];
      const Vector2d pixel(static_cast<double>(i % 752), static_cast<double>(i / 752));
      const Vector3d ray(face.rays.x[i], face.rays.y[i], 1);
      const Vector3d direction = bearing(camera, pixel)->bearing;
      ASSERT_LT((face.cam_R_face * ray.normalized() - direction).norm(), 1e-6) << pixel;
    }
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Vector2d pixel(static_cast<double>(i % 752), static_cast<double>(i / 752));
    ASSERT_EQ(times[i], bearing(camera, pixel) ? 1 : 0) << pixel;
  }
  EXPECT_EQ(times[0], 0);
  // Less than 90 degrees need one face alone.
  EXPECT_EQ(make_faces(fisheye(752, 480, 300)).size(), 1u);
}

TEST(Render, CornersBesideAndBehindACameraLieWhereTheyProject) {
  const PaintedWorld room = paint_world(chess_room(), 0.0025, 1);
  const Camera camera = fisheye(640, 640, 200);  // 92 degrees to the sides, 129 to the corners
  CornerErrors all;
  for (const double yaw : {0.0, 0.7, 2.1}) {
    const SE3 pose = looking(yaw, 0.1 * yaw, 0.2 - 0.1 * yaw, {0.4 * yaw, 0.3, -0.1 * yaw});
    const CornerErrors errors = corner_errors(room, camera, pose, -2);
    EXPECT_LT(errors.rms, 0.06);
    EXPECT_LT(errors.worst, 0.25);
    all.count += errors.count;
    all.beside += errors.beside;
  }
  EXPECT_GT(all.count, 300);
  EXPECT_GT(all.beside, 20);
}

}  // namespace
}  // namespace chasles
