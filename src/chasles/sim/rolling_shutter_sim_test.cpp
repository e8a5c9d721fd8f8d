#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_world.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/small_walk_testing.hpp>

// Cameras with a rolling shutter, in tracks and in images.
namespace chasles {
namespace {

InertialScene rolling(ReadoutDirection direction) {
  InertialScene scene = test::small_walk();
  scene.settings.readout_time = 0.03;
  scene.settings.readout_direction = direction;
  scene.settings.pixel_sigma = 0;
  scene.settings.min_range = 0.8;
  scene.settings.readout_noise = scene.settings.photon_noise = 0;
  return scene;
}

class RollingShutterOf : public testing::TestWithParam<ReadoutDirection> {};
INSTANTIATE_TEST_SUITE_P(Directions, RollingShutterOf,
                         testing::Values(ReadoutDirection::kDown, ReadoutDirection::kUp,
                                         ReadoutDirection::kRight, ReadoutDirection::kLeft),
                         [](const auto& info) { return std::string(name_of(info.param)); });

TEST_P(RollingShutterOf, SeesEachPointAtTheTimeOfItsLine) {
  const InertialScene scene = rolling(GetParam());
  const Spline motion = inertial_motion(scene);
  const Recording recording = simulate_inertial(scene);
  const Camera& camera = recording.cameras.front();
  EXPECT_EQ(camera.shutter.readout, 0.03);
  double most_moved = 0;
  for (const FeatureFrame& frame : recording.frames) {
    const double time = to_seconds(frame.time - motion.start);
    for (const PixelObservation& seen : frame.pixels) {
      const auto at = static_cast<std::size_t>(seen.landmark);
      ASSERT_EQ(recording.true_landmarks[at].id, seen.landmark);
      const Eigen::Vector3d& p_world = recording.true_landmarks[at].p_world;
      const auto pixel_at = [&](double t) {
        const SE3 world_T_imu = motion_at(motion, t).world_T_imu;
        return project(camera, camera.cam_T_imu * (world_T_imu.inverse() * p_world))->pixel;
      };
      EXPECT_LT((pixel_at(time + line_delay(camera, seen.pixel)) - seen.pixel).norm(), 1e-5);
      most_moved = std::max(most_moved, (pixel_at(time) - seen.pixel).norm());
    }
  }
  EXPECT_GT(most_moved, 3) << "pixels within the readout";
}

// Its lines are those of images that are taken when they are read.
TEST_P(RollingShutterOf, RendersEachLineAtItsTime) {
  InertialScene scene = rolling(GetParam());
  const Spline motion = inertial_motion(scene);
  const auto render_at = [&](const InertialScene& of, const std::vector<Time>& times) {
    return make_image_source(of.settings, 0,
                             paint_world(make_render_world(of.settings, motion), 0.02, 1, {}),
                             make_cameras(of.settings), motion, times);
  };
  const double turning = 3.4;  // [s]: in the first turn
  const Time time = motion.start + from_seconds(turning);
  const Camera camera = make_cameras(scene.settings).front();
  const GrayImage rolled = render_at(scene, {time})->read(0).images.front();
  const bool by_rows = GetParam() == ReadoutDirection::kDown || GetParam() == ReadoutDirection::kUp;
  InertialScene global = scene;
  global.settings.readout_time = 0;
  double apart = 0, apart_at_once = 0, pixels = 0;
  for (const int line : {3, 77, 140, 222}) {
    const Eigen::Vector2d on_line = by_rows ? Eigen::Vector2d(0, line) : Eigen::Vector2d(line, 0);
    const Time of_line = time + from_seconds(line_delay(camera, on_line));
    const auto both = render_at(global, {of_line, time});
    const GrayImage then = both->read(0).images.front(), at_once = both->read(1).images.front();
    for (int i = 0; i < (by_rows ? rolled.width : rolled.height); ++i) {
      const auto at =
          static_cast<std::size_t>(by_rows ? line * rolled.width + i : i * rolled.width + line);
      apart += std::abs(rolled.pixels[at] - then.pixels[at]);
      apart_at_once += std::abs(rolled.pixels[at] - at_once.pixels[at]);
      ++pixels;
    }
  }
  EXPECT_LT(apart / pixels, 0.6) << "shades";
  EXPECT_GT(apart_at_once / pixels, 3) << "shades";
}

TEST(RollingShutterSetting, IsNotLongerThanTheTimeBetweenFrames) {
  InertialScene scene = rolling(ReadoutDirection::kDown);
  scene.settings.frame_rate = 60;
  try {
    simulate_inertial(scene);
    FAIL() << "no error";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("readout_time"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace chasles
