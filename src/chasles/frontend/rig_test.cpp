#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include <chasles/camera/rig_overlap.hpp>
#include <chasles/frontend/frontend_walk_testing.hpp>

// Rigs whose cameras find tracks of their own.
namespace chasles::test {
namespace {

/// Small cameras with a view of 67 degrees, turned by equal angles; of 90 with a focal length of
/// 160.
std::vector<Camera> ring_of(int cameras, double focal = 240) {
  std::vector<Camera> rig;
  for (int i = 0; i < cameras; ++i) {
    Camera camera{.width = 320,
                  .height = 240,
                  .fx = focal,
                  .fy = focal,
                  .cx = 159.5,
                  .cy = 119.5,
                  .cam_T_imu = {}};
    const Eigen::Matrix3d imu_R_cam = so3::exp({0, 2 * std::numbers::pi * i / cameras, 0});
    camera.cam_T_imu = SE3{imu_R_cam, imu_R_cam * Eigen::Vector3d(0, 0, 0.1)}.inverse();
    rig.push_back(camera);
  }
  return rig;
}

int count_of(const FeatureFrame& frame, int camera, bool match) {
  return static_cast<int>(std::ranges::count_if(frame.pixels, [&](const PixelObservation& o) {
    return o.camera == camera && o.match == match;
  }));
}

TEST(FrontendOfARig, EachCameraOfARingFollowsItsTracks) {
  const Walk walk{.rig = ring_of(4), .path = sideways, .frames = 6};
  const Outcome out = follow(walk);
  std::map<LandmarkId, int> finder;
  for (int k = 0; k < walk.frames; ++k) {
    const FeatureFrame& frame = out.features[static_cast<std::size_t>(k)];
    for (int c = 0; c < 4; ++c) {
      EXPECT_GT(count_of(frame, c, false), 25) << c;
      EXPECT_LE(count_of(frame, c, false), tracks_per_finder(150, 4)) << c;
      EXPECT_EQ(count_of(frame, c, true), 0) << c;
    }
    for (const PixelObservation& o : frame.pixels) {
      EXPECT_EQ(finder.try_emplace(o.landmark, o.camera).first->second, o.camera);
    }
    EXPECT_TRUE(std::ranges::is_sorted(frame.pixels, {}, [](const PixelObservation& o) {
      return std::pair(o.camera, o.landmark);
    }));
  }
  // Against the truth, also in the camera that looks backward.
  const Camera& back = walk.rig[2];
  const auto first = of_camera(out.features[0], 2), last = of_camera(out.features[5], 2);
  std::vector<double> errors;
  for (const auto& [id, pixel] : last) {
    if (!first.contains(id)) continue;
    const auto truth =
        room().true_pixel(back, walk.path(0) * back.cam_T_imu.inverse(), first.at(id), back,
                          walk.path(5) * back.cam_T_imu.inverse());
    if (truth) errors.push_back((pixel - *truth).norm());
  }
  EXPECT_GT(errors.size(), 20u);
  EXPECT_LT(median(errors), 0.2);
  EXPECT_EQ(out.reports[5].cameras[2].found, static_cast<int>(last.size()));
}

TEST(FrontendOfARig, NeighboursThatOverlapMatchAndDoNotTrackAPointTwice) {
  const Walk walk{.rig = ring_of(5, 160), .path = sideways, .frames = 6};
  ASSERT_EQ(finders_of(walk.rig).size(), 5u);
  const Outcome out = follow(walk);
  const FeatureFrame& frame = out.features.back();
  int matches = 0;
  for (int c = 0; c < 5; ++c) {
    const auto pixels = of_camera(frame, c);
    matches += count_of(frame, c, true);
    EXPECT_EQ(count_of(frame, c, true),
              out.reports.back().cameras[static_cast<std::size_t>(c)].matched);
    for (auto a = pixels.begin(); a != pixels.end(); ++a) {
      for (auto b = std::next(a); b != pixels.end(); ++b) {
        EXPECT_GE((a->second - b->second).norm(), 3) << "one point twice in camera " << c;
      }
    }
  }
  EXPECT_GT(matches, 20);
}

TEST(FrontendOfARig, MatchesOfPartlyOverlappingCamerasAreRight) {
  const Walk walk{.rig = ring_of(5, 160), .path = sideways, .frames = 3};
  const FeatureFrame frame = follow(walk).features.back();
  const SE3 world_T_imu = walk.path(2);
  std::map<LandmarkId, const PixelObservation*> own;
  for (const PixelObservation& o : frame.pixels) {
    if (!o.is_match()) own[o.landmark] = &o;
  }
  int right = 0, all = 0;
  for (const PixelObservation& o : frame.pixels) {
    if (!o.is_match()) continue;
    const Camera &from = walk.rig[static_cast<std::size_t>(own.at(o.landmark)->camera)],
                 &to = walk.rig[static_cast<std::size_t>(o.camera)];
    const auto truth =
        room().true_pixel(from, world_T_imu * from.cam_T_imu.inverse(), own.at(o.landmark)->pixel,
                          to, world_T_imu * to.cam_T_imu.inverse());
    ++all;
    right += truth && (*truth - o.pixel).norm() < 1;
  }
  EXPECT_GT(all, 20);
  EXPECT_GT(right, 0.95 * all);
}

TEST(FrontendOfARig, TracksOfACameraWaitWhileItHasNoImage) {
  const Walk walk{.rig = ring_of(4), .path = sideways};
  Frontend frontend(walk.settings, walk.rig);
  std::set<LandmarkId> of_first;
  for (int k = 0; k < 8; ++k) {
    ImageFrame images = frame_of(walk, k);
    const bool without = k >= 2 && k < 6;
    if (without) images.images[0] = {};
    const FeatureFrame frame = frontend.process(
        images, k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
    EXPECT_EQ(count_of(frame, 0, false) == 0, without) << k;
    EXPECT_GT(count_of(frame, 1, false), 25) << k;
    EXPECT_EQ(frontend.report().missing_images, without ? 1 : 0);
    if (k == 1) {
      for (const auto& [id, pixel] : of_camera(frame, 0)) of_first.insert(id);
    }
    if (k == 6) {
      int again = 0;
      for (const auto& [id, pixel] : of_camera(frame, 0)) again += of_first.contains(id);
      EXPECT_GT(again, 15) << "tracks must be found again";
    }
  }
}

TEST(FrontendOfARig, ImagesOfOneCameraAtATimeGiveTheTracksOfEach) {
  const Walk walk{.rig = ring_of(4), .path = sideways};
  Frontend frontend(walk.settings, walk.rig);
  std::vector<int> tracked(4, 0);
  for (int k = 0; k < 12; ++k) {
    const int turn = k % 4;
    ImageFrame images = frame_of(walk, k);
    for (int c = 0; c < 4; ++c) {
      if (c != turn) images.images[static_cast<std::size_t>(c)] = {};
    }
    const FeatureFrame frame = frontend.process(
        images, k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
    for (const PixelObservation& o : frame.pixels) EXPECT_EQ(o.camera, turn);
    EXPECT_GT(frame.pixels.size(), 25u);
    tracked[static_cast<std::size_t>(turn)] += frontend.report().tracked;
  }
  for (const int n : tracked) EXPECT_GT(n, 30);
}

TEST(FrontendOfARig, TheMaskOfAFinderIsItsOwn) {
  const Walk walk{.rig = ring_of(4), .path = sideways};
  std::vector<GrayImage> masks(4);
  masks[3] = {.width = 320, .height = 240, .pixels = std::vector<std::uint8_t>(320 * 240, 0)};
  Frontend frontend(walk.settings, walk.rig, masks);
  const FeatureFrame frame = frontend.process(frame_of(walk, 0));
  EXPECT_EQ(count_of(frame, 3, false), 0);
  EXPECT_GT(count_of(frame, 2, false), 25);
}

TEST(FrontendOfARig, WithoutStereoThereAreTracksOfEachFinderAlone) {
  Walk walk{.rig = ring_of(5, 160), .path = sideways, .frames = 2};
  walk.settings.stereo = false;
  const FeatureFrame frame = follow(walk).features.back();
  for (int c = 0; c < 5; ++c) {
    EXPECT_GT(count_of(frame, c, false), 20);
    EXPECT_EQ(count_of(frame, c, true), 0);
  }
}

}  // namespace
}  // namespace chasles::test
