#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_world.hpp>
#include <chasles/sim/render.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/render_testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

// Small images of a short motion.
InertialScene small(const std::string& name) {
  InertialScene scene = inertial_scene(name);
  InertialSettings& s = scene.settings;
  s.image_width = 188;
  s.image_height = 120;
  s.focal_length = 115;
  s.center_u = 93.5;
  s.center_v = 59.5;
  s.texel_size = 0.02;
  s.cameras = 2;
  s.walk_duration = 12;
  if (name == "trajectory") {
    for (int i = 0; i <= 200; ++i) {
      const double a = i * 2 * std::numbers::pi / 200;
      scene.path.push_back({from_seconds(0.1 * i), test::looking(a, 0.1 * std::sin(2 * a), 0,
                                                                 {3 * std::sin(a), 2 * std::cos(a),
                                                                  0.5 * std::sin(3 * a)})});
    }
  }
  return scene;
}

TEST(RenderedImages, AnInterruptionEndsThePainting) {
  CallProgress progress;
  {
    const ObservedCall observed(progress);
    EXPECT_GT(render_inertial(small("walk")).images->size(), 0u);
    EXPECT_GT(progress.total, 3u) << "surfaces";
    EXPECT_EQ(progress.done + 1, progress.total);
    progress.stop = true;
    EXPECT_THROW(render_inertial(small("walk")), Interrupted);
    EXPECT_THROW(simulate_inertial(small("walk")), Interrupted);
  }
  EXPECT_FALSE(interruption_wanted()) << "nobody observes any more";
}

TEST(RenderedImages, HaveTheTimesTruthAndImuOfTheTracks) {
  const InertialScene scene = small("walk");
  const Recording images = render_inertial(scene, 3), tracks = simulate_inertial(scene, 3);
  ASSERT_EQ(images.images->size(), tracks.frames.size());
  ASSERT_EQ(images.imu.size(), tracks.imu.size());
  EXPECT_TRUE(images.frames.empty());
  EXPECT_TRUE(images.true_landmarks.empty());
  EXPECT_EQ(images.true_motion.size(), images.truth.size());
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
    EXPECT_EQ(images.images->time(i), tracks.frames[i].time);
    EXPECT_EQ(images.truth[i].pose.p, tracks.truth[i].pose.p);
  }
  EXPECT_EQ(images.imu.back().specific_force_imu, tracks.imu.back().specific_force_imu);
  const ImageFrame frame = images.images->read(5);
  EXPECT_EQ(frame.time, images.images->time(5));
  ASSERT_EQ(frame.images.size(), 2U);
  EXPECT_EQ(frame.images[1].width, 188);
  EXPECT_EQ(frame.images[1].pixels.size(), std::size_t{188} * 120);
}

TEST(RenderedImages, AreTheSameBytesInAnyOrderAndOthersInAnotherRun) {
  const InertialScene scene = small("walk");
  const Recording one = render_inertial(scene, 0), two = render_inertial(scene, 0);
  const Recording other = render_inertial(scene, 1);
  two.images->read(9);
  for (const std::size_t i : {std::size_t{7}, std::size_t{0}, std::size_t{100}}) {
    EXPECT_EQ(one.images->read(i).images[0].pixels, two.images->read(i).images[0].pixels);
    EXPECT_EQ(one.images->read(i).images[1].pixels, two.images->read(i).images[1].pixels);
    EXPECT_NE(one.images->read(i).images[0].pixels, other.images->read(i).images[0].pixels);
  }
}

// A sensor with unused shades at both ends has contrast in nearly every part of every image.
TEST(RenderedImages, AreFullOfContrastInEveryScene) {
  for (const InertialScene& known : inertial_scenes()) {
    const Recording recording = render_inertial(small(known.name));
    int dull = 0, saturated = 0, cells = 0, pixels = 0;
    for (std::size_t i = 0; i < recording.images->size(); i += recording.images->size() / 12) {
      const GrayImage image = recording.images->read(i).images[0];
      for (int y = 0; y + 24 <= image.height; y += 24) {
        for (int x = 0; x + 24 <= image.width; x += 24, ++cells) {
          int least = 255, most = 0;
          for (int k = 0; k < 24 * 24; ++k) {
            const int p =
                image.pixels[static_cast<std::size_t>((y + k / 24) * image.width + x + k % 24)];
            least = std::min(least, p);
            most = std::max(most, p);
            saturated += p == 255 || p == 0 ? 1 : 0;
            ++pixels;
          }
          dull += most - least < 30 ? 1 : 0;
        }
      }
    }
    EXPECT_LT(dull, 0.08 * cells) << known.name;
    EXPECT_LT(saturated, 0.03 * pixels) << known.name;
  }
}

TEST(RenderedImages, NoRoomHasAHoleAndNothingStandsOnTheWay) {
  for (const InertialScene& known : inertial_scenes()) {
    const InertialScene scene = small(known.name);
    const Spline motion = inertial_motion(scene);
    const RenderWorld world = make_render_world(scene.settings, motion);
    const PaintedWorld painted = paint_world(world, 0.05, 1);
    const Camera camera = make_cameras(scene.settings).front();
    const RayTable rays = make_rays(camera);
    for (int k = 0; k < 25; ++k) {
      const SE3 pose = motion_at(motion, motion.duration * k / 24).world_T_imu;
      const auto seen = visible_surfaces(painted, rays, pose * camera.cam_T_imu.inverse());
      EXPECT_EQ(std::ranges::count(seen, -1), 0) << known.name;
      for (const Box& box : world.furniture) {
        EXPECT_GT((pose.p - pose.p.cwiseMax(box.low).cwiseMin(box.high)).norm(), 0.5) << known.name;
      }
    }
    if (known.name == "trajectory") {
      EXPECT_GT(world.furniture.size(), 5U);
    }
  }
}

// Past a chessboard 2 m away at 1 m/s, f = 200 px: 100 px/s. At the frame's time the IMU is at
// y = 0, the camera 0.1 m to the left of it.
std::vector<double> edge_profile(double exposure_time) {
  InertialSettings s;
  s.readout_noise = s.photon_noise = 0;
  s.exposure_time = exposure_time;
  s.blur_samples = 40;
  Trajectory path;
  for (int i = 0; i <= 40; ++i) {
    path.push_back({from_seconds(0.05 * i), {Eigen::Matrix3d::Identity(), {1, 1 - 0.05 * i, 0}}});
  }
  const Spline motion = fit_spline(path, 0.1);
  Camera camera = test::forward_camera(320, 240, 200);
  SE3 imu_T_cam = camera.cam_T_imu.inverse();
  imu_T_cam.p.y() = 0.1;
  camera.cam_T_imu = imu_T_cam.inverse();
  const auto images = make_image_source(s, 0, paint_world(test::chess_room(), 0.005, 1), {camera},
                                        motion, {from_seconds(1)});
  const GrayImage image = images->read(0).images[0];
  std::vector<double> row;
  for (int u = 0; u < image.width; ++u)
    row.push_back(image.pixels[std::size_t{120 + 6} * 320 + static_cast<std::size_t>(u)]);
  return row;
}

// The positions at which an edge between two fields in the image's middle has a tenth and nine
// tenths of its rise.
struct Rise {
  double left, right;
  double width() const { return right - left; }
  double middle() const { return (left + right) / 2; }
};

Rise rise(const std::vector<double>& row) {
  const auto begin = row.begin() + 130, end = row.begin() + 200;
  const double low = *std::min_element(begin, end), high = *std::max_element(begin, end);
  std::size_t steep = 140;
  for (std::size_t u = 140; u < 190; ++u) {
    if ((row[u] - (low + high) / 2) * (row[u + 1] - (low + high) / 2) <= 0) steep = u;
  }
  const auto inside = [&](double shade) {
    return shade > low + 0.1 * (high - low) && shade < low + 0.9 * (high - low);
  };
  std::size_t left = steep, right = steep;
  while (left > 0 && inside(row[left])) --left;
  while (right + 1 < row.size() && inside(row[right])) ++right;
  return {static_cast<double>(left), static_cast<double>(right)};
}

TEST(RenderedImages, MotionBlursAnEdgeByTheWayOfItsImage) {
  EXPECT_LT(rise(edge_profile(0)).width(), 3.1);
  // 0.1 s * 100 px/s: eight tenths of 10 px, and the pixels themselves.
  EXPECT_NEAR(rise(edge_profile(0.1)).width(), 8, 2.1);
  EXPECT_NEAR(rise(edge_profile(0.2)).width(), 16, 2.1);
}

TEST(RenderedImages, ShowWhatIsSeenFromTheCameraInTheMiddleOfTheExposure) {
  for (const double exposure_time : {0.0, 0.1, 0.2}) {
    // Edges at multiples of 0.25 m, u = 159.7 + 200 * (0.1 - y) / 2.
    const double u = rise(edge_profile(exposure_time)).middle();
    EXPECT_LT(std::abs(std::remainder(u - 169.7, 25)), 1.1) << u;
  }
}

TEST(RenderedImages, RealSamplesBringTheirBiases) {
  InertialScene scene = small("trajectory");
  for (int i = 0; i < 1500; ++i) scene.imu.push_back({.time = from_seconds(2 + 0.01 * i)});
  EXPECT_TRUE(render_inertial(scene).true_motion.empty());
  scene.imu_truth = {{.time = from_seconds(2),
                      .v_world = Vector3d::Zero(),
                      .accelerometer_bias = Vector3d(1, 2, 3)},
                     {.time = from_seconds(6),
                      .v_world = Vector3d::Zero(),
                      .accelerometer_bias = Vector3d(4, 5, 6)}};
  const Recording recording = render_inertial(scene);
  ASSERT_EQ(recording.true_motion.size(), recording.truth.size());
  EXPECT_EQ(recording.true_motion.front().accelerometer_bias, Vector3d(1, 2, 3));
  EXPECT_EQ(recording.true_motion.back().accelerometer_bias, Vector3d(4, 5, 6));
  EXPECT_NEAR(recording.true_motion.front().v_world.norm(), 0.9, 0.5);
}

std::string complaint(const InertialScene& scene) {
  try {
    render_inertial(scene);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(RenderedImages, RejectWhatCannotBeRendered) {
  InertialScene scene = inertial_scene("trajectory");
  EXPECT_NE(complaint(scene).find("needs the poses"), std::string::npos);
  scene = small("trajectory");
  for (StampedPose& pose : scene.path) pose.pose.p *= 300;
  EXPECT_NE(complaint(scene).find("too large for images"), std::string::npos) << complaint(scene);
  scene = small("walk");
  scene.settings.exposure_time = 0.06;
  EXPECT_NE(complaint(scene).find("exposure_time = 0.06 s: expected at most"), std::string::npos);
  scene = small("walk");
  scene.settings.distortion = Distortion{77};
  EXPECT_NE(complaint(scene).find("distortion: found the value 77, expected one of none, radtan"),
            std::string::npos);
  scene.settings.distortion = Distortion::kRadtan;
  scene.settings.distortion_1 = -0.9;
  EXPECT_NE(complaint(scene).find("has no ray"), std::string::npos) << complaint(scene);
}

}  // namespace
}  // namespace chasles
