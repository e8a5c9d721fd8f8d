#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_testing.hpp>

// Pixels of cameras with a rolling shutter (camera/rolling_shutter.hpp).
namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::kPixelStep;

std::vector<Camera> rolling_cameras() {
  std::vector<Camera> cameras = test::kCameras;
  cameras[0].shutter = {.readout = 0.03};
  cameras[1].shutter = {.readout = 0.02, .direction = ReadoutDirection::kUp};
  cameras[2].shutter = {.readout = 0.01, .direction = ReadoutDirection::kLeft};
  return cameras;
}

// Poses with motions, and anchored landmarks on lines.
State rolling_state(test::Random& random, bool calibrating) {
  State x = test::some_filter(random, calibrating).state();
  x.readout = test::some_motion(random);
  for (Clone& clone : x.clones) clone.readout = test::some_motion(random);
  for (Landmark& landmark : x.landmarks) {
    if (!landmark.anchor) continue;
    landmark.imu_T_line = x.clone(*landmark.anchor).readout.after(0.013);
    landmark.cam_T_imu = landmark.cam_T_imu * landmark.imu_T_line.inverse();
  }
  return x;
}

// Where a camera sees a point from a pose with a motion: the pixel is that of its own line.
Vector2d seen_at_its_line(const Camera& camera, const SE3& world_T_imu, const ReadoutMotion& motion,
                          const Vector3d& p_world) {
  Vector2d pixel = test::pixel_of(camera, world_T_imu, p_world);
  for (int i = 0; i < 20; ++i) {
    pixel = test::pixel_of(camera, world_T_imu * motion.after(line_delay(camera, pixel)), p_world);
  }
  return pixel;
}

class RollingPixel : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Cameras, RollingPixel, testing::Bool(), test::how_known);

TEST_P(RollingPixel, IsThatOfItsLine) {
  test::Random random(3);
  const State x = rolling_state(random, GetParam());
  const std::vector<Camera> cameras = rolling_cameras();
  for (int index = 0; index < 3; ++index) {
    const Camera& known = cameras[static_cast<std::size_t>(index)];
    for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
      const Vector3d p_world = x.p_world(x.landmarks[static_cast<std::size_t>(i)]);
      const Vector2d pixel =
          seen_at_its_line(as_estimated(known, x, index), x.world_T_imu, x.readout, p_world);
      const auto z = measure_pixel(known, 1, x, i, pixel, Linearisation::kCurrent, index);
      ASSERT_TRUE(z);
      EXPECT_LT(z->residual.norm(), 1e-8);
    }
  }
}

TEST_P(RollingPixel, HasTheDerivativeOfItsResidual) {
  test::Random random(4);
  const State x = rolling_state(random, GetParam());
  const VectorXd zero = VectorXd::Zero(x.size());
  const std::vector<Camera> cameras = rolling_cameras();
  int anchored = 0;
  for (int index = 0; index < 3; ++index) {
    for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
      const auto measure = [&](const State& y) {
        return measure_pixel(cameras[static_cast<std::size_t>(index)], 1, y, i, {123, 234},
                             Linearisation::kCurrent, index);
      };
      const auto z = measure(x);
      ASSERT_TRUE(z);
      const auto residual = [&](const VectorXd& e) -> VectorXd {
        return measure(test::moved(kStandardChart, x, e))->residual;
      };
      const MatrixXd H = test::dense_measurement(x, {*z}).H;
      EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kPixelStep), 1e-9));
      anchored += x.landmarks[static_cast<std::size_t>(i)].anchor ? 1 : 0;
    }
  }
  EXPECT_EQ(anchored, 9);
}

// A landmark that a pixel initialises is seen at this pixel, whatever the depth.
TEST_P(RollingPixel, InitialisesItsLandmarkOnItsRay) {
  test::Random random(5);
  Ekf filter = test::some_filter(random, GetParam());
  filter.set_readout(test::some_motion(random));
  filter.clone_pose(17, {});
  const State& x = filter.state();
  const std::vector<Camera> cameras = rolling_cameras();
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = cameras[static_cast<std::size_t>(index)];
    const Vector2d pixel(140, 321);
    auto at_depth = initialise_at_depth(camera, 1, x, 200 + index, pixel, 5, 1, index);
    auto anchored = initialise_anchored(camera, 1, x, 300 + index, pixel, 0.2, 0.1, index);
    ASSERT_TRUE(at_depth && anchored);
    filter.add({&*at_depth, 1});
    filter.add({&*anchored, 1});
    for (const LandmarkId id : {200 + index, 300 + index}) {
      const auto found = std::ranges::find(x.landmarks, id, &Landmark::id);
      const auto z = measure_pixel(camera, 1, x, static_cast<int>(found - x.landmarks.begin()),
                                   pixel, Linearisation::kCurrent, index);
      ASSERT_TRUE(z);
      EXPECT_LT(z->residual.norm(), 1e-8) << id;
    }
  }
}

// Exact pixels of several views: the point is exact, what is left of the views is zero, and the
// point moves with clones and cameras as its derivative says.
TEST_P(RollingPixel, StartsALandmarkFromSeveralViews) {
  test::Random random(6);
  const State x = rolling_state(random, GetParam());
  const std::vector<Camera> cameras = rolling_cameras();
  const Vector3d p_world = x.world_T_imu * test::point_ahead(random, 8);
  std::vector<ClonedView> views;
  for (const Clone& clone : x.clones) {
    for (int index = 0; index < 2; ++index) {
      const Camera camera = as_estimated(cameras[static_cast<std::size_t>(index)], x, index);
      views.push_back(
          {.clone = clone.id,
           .camera = index,
           .pixel = seen_at_its_line(camera, clone.world_T_imu, clone.readout, p_world)});
    }
  }
  for (const bool anchored : {false, true}) {
    const auto start = initialise_multi_view(cameras, {.sigma = 1}, x, 7, views, anchored);
    ASSERT_TRUE(start);
    for (const Measurement& z : start->null_space) EXPECT_LT(z.residual.norm(), 1e-6);
    const auto parameters = [&](const State& y) -> VectorXd {
      const auto there = initialise_multi_view(cameras, {.sigma = 1}, y, 7, views, anchored);
      return anchored ? there->landmark.inverse_depth : there->landmark.p_world;
    };
    if (!anchored) {
      EXPECT_TRUE(test::agree(parameters(x), p_world, 1e-8));
    }
    MatrixXd D = MatrixXd::Zero(3, x.size());
    for (const auto& clone : start->landmark.clones) D.middleCols<6>(clone.row) += clone.d;
    const auto moved = [&](const VectorXd& e) -> VectorXd {
      return parameters(test::moved(kStandardChart, x, e));
    };
    const VectorXd zero = VectorXd::Zero(x.size());
    EXPECT_TRUE(test::agree(D, test::numeric_derivative(moved, zero, 1e-5), 1e-5)) << anchored;
  }
}

}  // namespace
}  // namespace chasles
