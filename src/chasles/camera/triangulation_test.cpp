#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/base/constants.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

constexpr double kNoEnd = std::numeric_limits<double>::infinity();

// Camera coordinates of an IMU whose x axis is the optical axis of the camera, with a lever arm.
SE3 mounted(const Eigen::Vector3d& p_imu_cam) {
  Eigen::Matrix3d cam_R_imu;
  cam_R_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const SE3 tilted{cam_R_imu * so3::exp({0.02, -0.03, 0.05}), Eigen::Vector3d::Zero()};
  return {tilted.R, -(tilted.R * p_imu_cam)};
}

// Three lenses on one body.
const std::vector<Camera>& rig() {
  static const std::vector<Camera> cameras = [] {
    std::vector<Camera> all = {test::pinhole_camera(), test::euroc_camera(),
                               test::fisheye_camera()};
    all[0].cam_T_imu = mounted({0.1, 0.05, 0});
    all[1].cam_T_imu = mounted({0.1, -0.06, 0.02});
    all[2].cam_T_imu = mounted({0.08, 0.01, -0.04});
    return all;
  }();
  return cameras;
}

// Poses along a path of the given length about `middle`, oriented roughly along x.
std::vector<SE3> path(test::Random& random, const Eigen::Vector3d& middle,
                      const Eigen::Vector3d& direction, int count) {
  std::vector<SE3> poses;
  for (int i = 0; i < count; ++i) {
    const double along = static_cast<double>(i) / (count - 1) - 0.5;
    poses.push_back({so3::exp(0.1 * random.normal_vector(3)), middle + along * direction});
  }
  return poses;
}

// The exact views of a point, with the named cameras in turn.
std::vector<View> views_of(const Eigen::Vector3d& p_world, const std::vector<SE3>& poses,
                           const std::vector<std::size_t>& cameras) {
  std::vector<View> views;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Camera& camera = rig()[cameras[i % cameras.size()]];
    const auto seen = project(camera, camera.cam_T_imu * (poses[i].inverse() * p_world));
    if (!seen) ADD_FAILURE() << "the point is not in view " << i;
    if (seen) views.push_back({.world_T_imu = poses[i], .camera = &camera, .pixel = seen->pixel});
  }
  return views;
}

std::vector<View> with_noise(std::vector<View> views, test::Random& random, double sigma) {
  for (View& view : views) view.pixel += sigma * random.normal_vector(2);
  return views;
}

// The reprojection residuals of all views, stacked.
Eigen::VectorXd residuals(const std::vector<View>& views, const Eigen::Vector3d& p_world) {
  Eigen::VectorXd all(2 * static_cast<Eigen::Index>(views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = *views[i].camera;
    const Eigen::Vector3d p_cam = camera.cam_T_imu * (views[i].world_T_imu.inverse() * p_world);
    all.segment<2>(2 * static_cast<Eigen::Index>(i)) =
        views[i].pixel - project(camera, p_cam)->pixel;
  }
  return all;
}

const std::vector<std::vector<std::size_t>>& camera_choices() {
  static const std::vector<std::vector<std::size_t>> choices = {{0}, {1}, {2}, {0, 1}, {2, 1, 0}};
  return choices;
}

TEST(Triangulation, ExactViewsGiveThePoint) {
  test::Random random(41);
  const Eigen::Vector3d middle(300, -200, 10);
  for (const auto& cameras : camera_choices()) {
    for (const Eigen::Vector3d& direction :
         std::vector<Eigen::Vector3d>{{0, 2, 0}, {0.3, 0.1, 0.1}, {2, 0.2, 0}, {0, 0, -1}}) {
      for (const int count : {2, 3, 20}) {
        for (const double depth : {2.0, 8.0, 40.0}) {
          const Eigen::Vector3d p = middle + depth * Eigen::Vector3d(1, 0.08, 0.05);
          const auto views = views_of(p, path(random, middle, direction, count), cameras);
          const auto found = triangulate(views);
          ASSERT_TRUE(found) << depth << " " << direction.transpose();
          // Positions near 300 m carry 6e-14 m of round-off, which little parallax magnifies.
          EXPECT_LT((found->p_world - p).norm(), 1e-9) << depth << " " << direction.transpose();
          EXPECT_LT(found->rms, 1e-9);
        }
      }
    }
  }
}

TEST(Triangulation, AnInstantsViewsFromTwoCamerasSuffice) {
  const SE3 pose{so3::exp({0.3, -0.2, 1}), {4, 5, 6}};
  const Eigen::Vector3d p = pose * Eigen::Vector3d(5, 0.4, -0.3);
  const auto found = triangulate(views_of(p, {pose, pose}, {0, 1}));
  ASSERT_TRUE(found);
  EXPECT_LT((found->p_world - p).norm(), 1e-9);
}

// Directions on all sides of a fisheye camera that sees 150 degrees off its axis, also straight up,
// sideways and backward.
TEST(Triangulation, APointBesideOrBehindTheCamerasIsFound) {
  test::Random random(49);
  int behind = 0;
  for (int round = 0; round < 300; ++round) {
    const Eigen::Vector3d direction = random.axis();
    if (direction.x() < -0.7) continue;  // x is the optical axis
    behind += direction.x() < 0;
    const Eigen::Vector3d p = random.uniform(2, 20) * direction;
    const auto poses = path(random, {0, 0, 0}, random.axis(), 8);
    const auto exact = views_of(p, poses, {2});
    const auto found = triangulate(exact);
    if (!found) {
      // Along the path there is no parallax.
      EXPECT_GT(std::abs(direction.dot((poses[7].p - poses[0].p).normalized())), 0.97);
      continue;
    }
    const double scale = 1 / found->parallax;
    EXPECT_LT((found->p_world - p).norm(), 1e-9 * scale * scale) << direction.transpose();
    if (found->parallax < 0.03) continue;
    // The least-squares point, and its normal matrix.
    const auto views = with_noise(exact, random, 0.2);
    const auto noisy = triangulate(views);
    ASSERT_TRUE(noisy);
    const auto error = [&](const Eigen::Vector3d& q) { return residuals(views, q); };
    const Eigen::MatrixXd J = test::numeric_derivative(error, noisy->p_world);
    const Eigen::Matrix3d information = J.transpose() * J;
    const Eigen::Vector3d left =
        information.ldlt().solve(J.transpose() * residuals(views, noisy->p_world));
    EXPECT_LT(std::sqrt(left.dot(information * left)), 1e-6);
    EXPECT_TRUE(test::agree(Eigen::Matrix3d(noisy->covariance * information),
                            Eigen::Matrix3d::Identity(), 1e-5));
  }
  EXPECT_GT(behind, 80);
}

// Two cameras back to back, of 200 degrees each, share the points beside them.
TEST(Triangulation, TwoCamerasBackToBackShareTheirRims) {
  Camera front = test::fisheye_camera(), back = front;
  back.cam_T_imu.R = so3::exp({0, std::numbers::pi, 0});
  back.cam_T_imu.p = {0, 0, -0.05};
  for (const double around : {0.0, 1.0, 2.5, 4.4}) {
    const Eigen::Vector3d p(1.5 * std::cos(around), 1.5 * std::sin(around), 0.1);
    std::vector<View> views;
    for (const Camera* camera : {&front, &back}) {
      const auto seen = project(*camera, camera->cam_T_imu * p);
      ASSERT_TRUE(seen);
      views.push_back({.world_T_imu = {}, .camera = camera, .pixel = seen->pixel});
    }
    const auto found = triangulate(views);
    ASSERT_TRUE(found);
    EXPECT_LT((found->p_world - p).norm(), 1e-9);
  }
}

TEST(Triangulation, TheOrderOfTheViewsDoesNotMatter) {
  test::Random random(42);
  const auto poses = path(random, {0, 0, 0}, {0.5, 1, 0}, 9);
  auto views = with_noise(views_of({7, 1, 0.5}, poses, {0, 1, 2}), random, 1);
  const auto found = triangulate(views);
  std::reverse(views.begin(), views.end());
  const auto reversed = triangulate(views);
  ASSERT_TRUE(found && reversed);
  EXPECT_TRUE(test::agree(reversed->p_world, found->p_world, 1e-9));
  EXPECT_TRUE(test::agree(reversed->covariance, found->covariance, 1e-8, 1e-300));
}

TEST(Triangulation, NoisyViewsGiveTheLeastSquaresPointAndItsNormalMatrix) {
  test::Random random(43);
  for (int round = 0; round < 30; ++round) {
    const double z = random.uniform(-1, 1), y = random.uniform(-1, 1), x = random.uniform(3, 15);
    const Eigen::Vector3d p(x, y, z);
    const auto poses = path(random, {0, 0, 0}, random.axis(), 12);
    const auto views = with_noise(views_of(p, poses, camera_choices()[round % 5]), random, 1);
    const auto found = triangulate(views);
    ASSERT_TRUE(found);
    const auto error = [&](const Eigen::Vector3d& q) { return residuals(views, q); };
    const Eigen::MatrixXd J = test::numeric_derivative(error, found->p_world);
    const Eigen::Matrix3d information = J.transpose() * J;
    const Eigen::VectorXd e = residuals(views, found->p_world);
    // The remaining step, in standard deviations.
    const Eigen::Vector3d left = information.ldlt().solve(J.transpose() * e);
    EXPECT_LT(std::sqrt(left.dot(information * left)), 1e-7);
    const Eigen::Matrix3d product = found->covariance * information;
    EXPECT_TRUE(test::agree(product, Eigen::Matrix3d::Identity(), 1e-6));
    EXPECT_NEAR(found->rms, std::sqrt(e.squaredNorm() / static_cast<double>(e.size())), 1e-12);
  }
}

TEST(Triangulation, TheCovarianceIsThatOfManyNoisyTrials) {
  test::Random random(44);
  const Eigen::Vector3d p(6, 0.7, 0.4);
  const double sigma = 0.5;
  const auto exact = views_of(p, path(random, {0, 0, 0}, {0.3, 2, 0.2}, 20), {1, 2});
  const int trials = 4000;
  double nees = 0;
  double squares = 0;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (int i = 0; i < trials; ++i) {
    const auto found = triangulate(with_noise(exact, random, sigma));
    ASSERT_TRUE(found);
    const Eigen::Vector3d error = found->p_world - p;
    nees += error.dot(found->covariance.ldlt().solve(error)) / (sigma * sigma);
    squares += found->rms * found->rms * static_cast<double>(2 * exact.size()) / (sigma * sigma);
    scatter += error * error.transpose() / (trials * sigma * sigma);
  }
  // Sums of chi-square variables, 4 standard deviations: 3 and 2 n - 3 degrees of freedom each.
  const double dof = 2 * static_cast<double>(exact.size()) - 3;
  EXPECT_NEAR(nees / trials, 3, 4 * std::sqrt(6.0 / trials));
  EXPECT_NEAR(squares / trials, dof, 4 * std::sqrt(2 * dof / trials));
  EXPECT_TRUE(test::agree(scatter, triangulate(exact)->covariance, 0.1, 1e-300));
}

TEST(Triangulation, ParallaxIsTheLargestAngleAtThePoint) {
  const std::vector<SE3> poses = {{so3::exp({0, 0, 0}), {0, -1, 0}},
                                  {so3::exp({0, 0, 0}), {0, 0.2, 0}},
                                  {so3::exp({0, 0, 0}), {0, 1, 0}}};
  std::vector<View> views = views_of({5, 0, 0}, poses, {2});
  const Eigen::Vector3d lever = rig()[2].cam_T_imu.inverse().p;
  const double expected =
      std::atan2(1 - lever.y(), 5 - lever.x()) + std::atan2(1 + lever.y(), 5 - lever.x());
  // The height of the lever arm tilts the plane of the two rays, by less than 1e-4 of the angle.
  EXPECT_NEAR(triangulate(views)->parallax, expected, 1e-4 * expected);
  std::swap(views[0], views[1]);
  EXPECT_NEAR(triangulate(views)->parallax, expected, 1e-4 * expected);
}

// The camera rotates about its own centre: the direction is observable, the distance is not.
TEST(Triangulation, APureRotationMeansNoPoint) {
  test::Random random(45);
  for (const double noise : {0.0, 1.0}) {
    for (std::size_t camera = 0; camera < 3; ++camera) {
      const SE3 imu_T_cam = rig()[camera].cam_T_imu.inverse();
      std::vector<SE3> poses;
      for (int i = 0; i < 10; ++i) {
        const Eigen::Matrix3d R = so3::exp(0.1 * random.normal_vector(3));
        poses.push_back({R, Eigen::Vector3d(100, 20, 3) - R * imu_T_cam.p});
      }
      const auto views = views_of({110, 21, 3}, poses, {camera});
      EXPECT_FALSE(triangulate(with_noise(views, random, noise)));
    }
  }
}

// All centres on the line through the point: moving it along the line moves no pixel.
TEST(Triangulation, MotionStraightToThePointMeansNoPoint) {
  std::vector<SE3> poses;
  for (const double x : {0.0, 0.5, 1.0}) poses.push_back({Eigen::Matrix3d::Identity(), {x, 0, 0}});
  const Camera& camera = rig()[0];
  const Eigen::Vector3d on_line = camera.cam_T_imu.inverse().p + Eigen::Vector3d(9, 0, 0);
  EXPECT_FALSE(triangulate(views_of(on_line, poses, {0})));
  EXPECT_TRUE(triangulate(views_of(on_line + Eigen::Vector3d(0, 0.1, 0), poses, {0})));
}

TEST(Triangulation, AFarPointIsNoneOrUncertain) {
  test::Random random(46);
  const auto poses = path(random, {0, 0, 0}, {0, 0.2, 0}, 5);
  const Eigen::Vector3d p(3000, 20, 10);
  int found = 0;
  for (int i = 0; i < 200; ++i) {
    const auto point = triangulate(with_noise(views_of(p, poses, {1}), random, 1));
    if (!point) continue;
    ++found;
    const double depth = point->p_world.norm();
    EXPECT_GT(std::sqrt(point->covariance.trace()), 0.1 * depth);
  }
  // The rays diverge in half of the trials.
  EXPECT_NEAR(found, 100, 4 * std::sqrt(50.0));
}

TEST(Triangulation, ParallelRaysMeanNoPoint) {
  std::vector<View> views;
  for (const double y : {-1.0, 0.0, 1.0}) {
    views.push_back({.world_T_imu = {Eigen::Matrix3d::Identity(), {0, y, 0}},
                     .camera = rig().data(),
                     .pixel = {500, 100}});
  }
  EXPECT_FALSE(triangulate(views));
}

// Pixels of a point behind both cameras: the rays diverge.
TEST(Triangulation, APointBehindTheCamerasIsNone) {
  test::Random random(47);
  auto views = views_of({5, 0, 0}, path(random, {0, 0, 0}, {0, 1, 0}, 4), {0});
  const std::vector<View> before = views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].world_T_imu.p.y() *= -1;
  }
  EXPECT_TRUE(triangulate(before));
  EXPECT_FALSE(triangulate(views));
}

TEST(Triangulation, APointNearerThanTheLeastDepthIsNone) {
  const Camera camera = test::pinhole_camera();
  const auto pair = [&](double z) {
    std::vector<View> views;
    for (const double x : {-0.01, 0.01}) {
      views.push_back({.world_T_imu = {Eigen::Matrix3d::Identity(), {x, 0, 0}},
                       .camera = &camera,
                       .pixel = {camera.cx - camera.fx * x / z, camera.cy}});
    }
    return triangulate(views);
  };
  EXPECT_FALSE(pair(0.09));
  ASSERT_TRUE(pair(0.11));
  EXPECT_NEAR(pair(0.11)->p_world.z(), 0.11, 1e-12);
}

TEST(Triangulation, TooFewOrUnusableViewsMeanNoPoint) {
  test::Random random(48);
  const auto views = views_of({5, 0, 0}, path(random, {0, 0, 0}, {0, 1, 0}, 3), {2});
  EXPECT_TRUE(triangulate(views));
  EXPECT_FALSE(triangulate({}));
  EXPECT_FALSE(triangulate(std::span(views).first(1)));
  for (const double bad : {kNaN, kNoEnd, 1e6}) {
    auto broken = views;
    broken[1].pixel.y() = bad;
    EXPECT_FALSE(triangulate(broken)) << bad;
  }
  auto broken = views;
  broken[1].world_T_imu.p.x() = kNaN;
  EXPECT_FALSE(triangulate(broken));
  broken = views;
  broken[2].camera = nullptr;
  EXPECT_FALSE(triangulate(broken));
}

TEST(Triangulation, ResidualsNearRoundOffDoNotRejectThePoint) {
  test::Random random(77);
  int found = 0;
  constexpr int kTrials = 500;
  for (int i = 0; i < kTrials; ++i) {
    const double z = random.uniform(-1, 1), y = random.uniform(-1, 1), x = random.uniform(4, 9);
    const Eigen::Vector3d p_world(x, y, z);
    const auto poses = path(random, {0, 0, 0}, {0.2, 0.8, 0.1}, 5);
    found += triangulate(with_noise(views_of(p_world, poses, {0}), random, 0.01)).has_value();
  }
  EXPECT_EQ(found, kTrials);
}

}  // namespace
}  // namespace chasles
