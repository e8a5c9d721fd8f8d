#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <chasles/frontend/frontend_walk_testing.hpp>

namespace chasles::test {
namespace {

// A gyroscope does not measure the growth of the image in forward motion; a kept patch does.
TEST(KeptPatches, DriftLessWhereTheImageGrows) {
  const auto forward = [](int k) {
    return SE3{Eigen::Matrix3d::Identity(), {0.1, -0.05, 0.04 * k - 1}};
  };
  Walk walk{.path = forward, .frames = 20, .settings = {.max_stretch = 1000}};
  const double kept = median(follow(walk).total_errors);
  walk.settings.patch_frames = 1;
  const double from_image_to_image = median(follow(walk).total_errors);
  RecordProperty("kept_px", std::to_string(kept));
  RecordProperty("from_image_to_image_px", std::to_string(from_image_to_image));
  EXPECT_LT(kept, 0.7 * from_image_to_image) << kept << " " << from_image_to_image;
  EXPECT_LT(kept, 0.2);
}

/// How much nearer each track's point is in the last frame than in the track's first one.
std::map<LandmarkId, double> growth(const Walk& walk, const Outcome& out) {
  const auto depth = [&](int k, const Eigen::Vector2d& pixel) {
    const SE3 world_T_cam = walk.path(k) * walk.rig[0].cam_T_imu.inverse();
    const Eigen::Vector3d point = room().hit(world_T_cam, unproject(walk.rig[0], pixel)->ray);
    return (world_T_cam.inverse() * point).z();
  };
  std::map<LandmarkId, double> first, ratios;
  for (int k = 0; k < walk.frames; ++k) {
    for (const auto& [id, pixel] : of_camera(out.features[static_cast<std::size_t>(k)], 0)) {
      first.try_emplace(id, depth(k, pixel));
      if (k == walk.frames - 1) ratios[id] = first.at(id) / depth(k, pixel);
    }
  }
  return ratios;
}

// At twice the scale, another point near the same place is the corner.
TEST(KeptPatches, ATrackEndsWhereItsPatchIsStretched) {
  const auto forward = [](int k) {
    return SE3{Eigen::Matrix3d::Identity(), {0.1, -0.05, 0.06 * k - 1}};
  };
  const auto longest = [&](double max_stretch, int& ended) {
    const Walk walk{.path = forward, .frames = 22, .settings = {.max_stretch = max_stretch}};
    const Outcome out = follow(walk);
    ended = 0;
    for (const FrontendReport& report : out.reports) ended += report.lost_changed;
    double most = 0;
    for (const auto& [id, ratio] : growth(walk, out)) most = std::max(most, ratio);
    return most;
  };
  int ended = 0, ended_without = 0;
  EXPECT_LT(longest(1.15, ended), 1.25);  // it is checked in every third image
  EXPECT_GT(longest(1000, ended_without), 1.4);
  EXPECT_GT(ended, ended_without + 50);
}

// A board slides slowly in front of the wall: a corner of its edge with the background is not a
// point.
TEST(KeptPatches, ATrackEndsWhereAnEdgeCoversWhatIsBehindIt) {
  const GrayImage board = room().render(euroc_rig()[0], spin(3));
  const auto on_the_edge = [&](double min_kept_correlation) {
    const Walk walk{.path = [](int) { return walk_pose(0); },
                    .frames = 25,
                    .settings = {.max_tracks = 600,
                                 .min_distance = 6,
                                 .min_correlation = 0.8,
                                 .min_kept_correlation = min_kept_correlation,
                                 .reject_outliers = false}};
    Frontend frontend(walk.settings, walk.rig);
    std::map<LandmarkId, int> ages;
    int count = 0;
    for (int k = 0; k < walk.frames; ++k) {
      ImageFrame frame = frame_of(walk, k);
      const int left = 200 + k / 3;
      for (int y = 40; y < 440; ++y) {
        for (int x = left; x < left + 250; ++x) {
          frame.images[0].pixels[static_cast<std::size_t>(y * 752 + x)] =
              board.pixels[static_cast<std::size_t>(y * 752 + x - left + 100)];
        }
      }
      const FeatureFrame features = frontend.process(
          frame, k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
      for (const auto& [id, pixel] : of_camera(features, 0)) {
        const double to_edge =
            std::min(std::abs(pixel.x() - left), std::abs(pixel.x() - left - 250));
        const bool old = ++ages[id] > 12;
        if (k == walk.frames - 1 && old && to_edge < 4 && pixel.y() > 50 && pixel.y() < 430)
          ++count;
      }
    }
    return count;
  };
  const int followed = on_the_edge(-1);
  EXPECT_GT(followed, 5);
  EXPECT_LT(on_the_edge(FrontendSettings{}.min_kept_correlation), followed / 2);
}

// In a dark room all patches differ from the kept ones, and equally from those of the last image.
TEST(KeptPatches, NoiseDoesNotEndTracks) {
  const Walk walk{.path = sideways, .frames = 14};
  Frontend frontend(walk.settings, walk.rig);
  int tracked = 0, changed = 0;
  for (int k = 0; k < walk.frames; ++k) {
    const SE3 world_T_cam = walk.path(k) * walk.rig[0].cam_T_imu.inverse();
    ImageFrame frame = frame_of(walk, k);
    frame.images[0] =
        room().render(walk.rig[0], world_T_cam, 0.25, 0, 3.5, static_cast<std::uint64_t>(k + 1));
    frontend.process(frame, k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
    tracked += frontend.report().tracked;
    changed += frontend.report().lost_changed;
  }
  RecordProperty("tracked", tracked);
  RecordProperty("changed", changed);
  EXPECT_GT(tracked, 1000);
  EXPECT_LT(changed, 0.05 * tracked) << tracked;
}

}  // namespace
}  // namespace chasles::test
