#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/frontend/frontend_walk_testing.hpp>

namespace chasles::test {
namespace {

TEST(Frontend, FollowsTranslationToATenthOfAPixel) {
  const Outcome out = follow({.path = sideways});
  EXPECT_LT(median(out.step_errors), 0.05);
  EXPECT_LT(median(out.total_errors), 0.15);
  EXPECT_GT(out.tracked_share, 0.97);
  EXPECT_EQ(out.reports.back().mean_age > 6, true);
}

TEST(Frontend, FollowsAWalk) {
  for (const bool gyroscope : {true, false}) {
    const Outcome out = follow({.frames = 20, .gyroscope = gyroscope});
    EXPECT_LT(median(out.step_errors), 0.06) << gyroscope;
    EXPECT_LT(median(out.total_errors), gyroscope ? 0.3 : 0.4) << gyroscope;
    EXPECT_GT(out.tracked_share, 0.95) << gyroscope;
  }
}

TEST(Frontend, DoesNotDriftWhereTheGyroscopeShowsHowPatchesTurn) {
  const auto roll = [](int k) { return SE3{so3::exp(Eigen::Vector3d(0, 0, 0.02 * k)), {0, 0, 0}}; };
  EXPECT_LT(median(follow({.path = roll, .frames = 15}).total_errors), 0.06);
}

TEST(Frontend, SurvivesThirtyDegreesAFrameWithTheGyroscopeAndNotWithout) {
  const Outcome with = follow({.path = spin, .frames = 4});
  EXPECT_GT(with.tracked_share, 0.9);
  EXPECT_LT(median(with.step_errors), 0.1);
  for (std::size_t k = 1; k < 4; ++k) EXPECT_GT(with.reports[k].tracked, 30);
  const Outcome without = follow({.path = spin, .frames = 4, .gyroscope = false});
  EXPECT_LT(without.tracked_share, 0.1);
}

TEST(Frontend, FollowsThroughAFisheye) {
  Camera camera = fisheye_camera();
  camera.cam_T_imu = euroc_rig()[0].cam_T_imu;
  const Outcome out = follow({.rig = {camera}, .frames = 10});
  EXPECT_LT(median(out.step_errors), 0.08);
  EXPECT_GT(out.tracked_share, 0.95);
}

TEST(Frontend, KeepsTheBudgetAndNeverReusesAnId) {
  const Outcome out = follow({.frames = 15, .settings = {.max_tracks = 60}});
  std::set<LandmarkId> seen, last;
  for (const FeatureFrame& frame : out.features) {
    EXPECT_LE(frame.pixels.size(), 60U);
    EXPECT_GE(frame.pixels.size(), 50U);
    std::set<LandmarkId> now;
    for (const PixelObservation& o : frame.pixels) {
      EXPECT_TRUE(now.insert(o.landmark).second);
      if (!last.contains(o.landmark)) {
        EXPECT_TRUE(seen.insert(o.landmark).second) << "an id came back: " << o.landmark;
      }
    }
    last = now;
  }
}

TEST(Frontend, ReportsWhatBecameOfEachTrack) {
  const Outcome out = follow({.frames = 20});
  std::size_t last = 0;
  for (std::size_t k = 0; k < out.reports.size(); ++k) {
    const FrontendReport& r = out.reports[k];
    EXPECT_EQ(r.time, out.features[k].time);
    EXPECT_EQ(static_cast<std::size_t>(r.tracked + r.lost()), last);
    EXPECT_EQ(static_cast<std::size_t>(r.tracked + r.added), out.features[k].pixels.size());
    EXPECT_TRUE(k == 0 || r.motion_decided);
    EXPECT_LT(r.rotation_correction, 2e-3);
    last = out.features[k].pixels.size();
  }
  EXPECT_GT(out.reports.back().lost_left_image + out.reports[10].lost_left_image, 0);
  EXPECT_GT(out.reports.back().median_age, 3);
}

TEST(Frontend, FindsTheSamePointsInTheOtherCamera) {
  Walk walk{.rig = euroc_rig(), .frames = 8};
  const Outcome out = follow(walk);
  double right = 0, found = 0, visible = 0;
  for (int k = 0; k < walk.frames; ++k) {
    const SE3 world_T_cam0 = walk.path(k) * walk.rig[0].cam_T_imu.inverse();
    const SE3 world_T_cam1 = walk.path(k) * walk.rig[1].cam_T_imu.inverse();
    const auto first = of_camera(out.features[static_cast<std::size_t>(k)], 0);
    const auto other = of_camera(out.features[static_cast<std::size_t>(k)], 1);
    EXPECT_EQ(static_cast<int>(other.size()),
              out.reports[static_cast<std::size_t>(k)].stereo_matched);
    for (const auto& [id, pixel] : first) {
      const auto truth =
          room().true_pixel(walk.rig[0], world_T_cam0, pixel, walk.rig[1], world_T_cam1);
      if (truth && in_image(walk.rig[1], *truth, 10)) visible += 1;
      if (!other.contains(id)) continue;
      found += 1;
      if (truth && (other.at(id) - *truth).norm() < 1) right += 1;
    }
  }
  EXPECT_GT(right, 0.98 * found);
  EXPECT_GT(right, 0.93 * visible);
}

TEST(Frontend, ThrowsOutWhatMovesOnItsOwn) {
  // A textured board that moves across the image while the rig moves.
  const Walk walk{.path = sideways, .frames = 8};
  Frontend frontend(walk.settings, walk.rig);
  const GrayImage board = room().render(walk.rig[0], spin(3));
  int on_board = 0, outliers = 0;
  for (int k = 0; k < walk.frames; ++k) {
    ImageFrame frame = frame_of(walk, k);
    const int x0 = 250 + 9 * k, y0 = 120 + 7 * k;  // across the motion of the walls
    for (int y = y0; y < y0 + 160; ++y) {
      for (int x = x0; x < x0 + 200; ++x) {
        const int source = (y - y0 + 100) * 752 + x - x0 + 200;
        frame.images[0].pixels[static_cast<std::size_t>(y * 752 + x)] =
            board.pixels[static_cast<std::size_t>(source)];
      }
    }
    const FeatureFrame features = frontend.process(
        frame, k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
    outliers += frontend.report().lost_outlier;
    on_board = 0;
    const int added_from = frontend.report().tracked;
    for (int i = 0; i < added_from; ++i) {
      const Eigen::Vector2d& p = features.pixels[static_cast<std::size_t>(i)].pixel;
      if (p.x() > x0 + 8 && p.x() < x0 + 192 && p.y() > y0 + 8 && p.y() < y0 + 152) ++on_board;
    }
    EXPECT_LE(on_board, 1) << k;
  }
  EXPECT_GT(outliers, 20);
}

TEST(Frontend, TracksNothingBehindAMask) {
  const Walk walk{.rig = euroc_rig(), .frames = 6};
  GrayImage mask{.width = 752, .height = 480, .pixels = std::vector<std::uint8_t>(752 * 480, 255)};
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (i % 752 < 300) mask.pixels[i] = 0;
  }
  Frontend frontend(walk.settings, walk.rig, {mask, mask});
  for (int k = 0; k < walk.frames; ++k) {
    const FeatureFrame features = frontend.process(
        frame_of(walk, k), k > 0 ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{});
    EXPECT_GT(features.pixels.size(), 150U);
    for (const PixelObservation& o : features.pixels) EXPECT_GE(o.pixel.x(), 299);
  }
}

TEST(Frontend, EachEqualisationAndCornerMeasureFollows) {
  for (const Equalisation equalisation :
       {Equalisation::kNone, Equalisation::kHistogram, Equalisation::kClahe}) {
    for (const CornerMeasure corners : {CornerMeasure::kHarris, CornerMeasure::kShiTomasi}) {
      const Outcome out = follow({.path = sideways,
                                  .frames = 5,
                                  .settings = {.corners = corners, .equalisation = equalisation}});
      EXPECT_GT(out.tracked_share, 0.95) << name_of(equalisation) << name_of(corners);
      EXPECT_LT(median(out.step_errors), 0.1) << name_of(equalisation) << name_of(corners);
    }
  }
}

TEST(Frontend, DoesNotMindAChangeOfExposure) {
  const Camera camera = euroc_rig()[0];
  Frontend frontend({}, {camera});
  const SE3 imu_T_cam = camera.cam_T_imu.inverse();
  frontend.process({from_seconds(1), {room().render(camera, sideways(0) * imu_T_cam)}});
  const auto first = frontend.report().added;
  frontend.process({from_seconds(1.05), {room().render(camera, sideways(1) * imu_T_cam, 0.5, 20)}},
                   gyroscope(sideways(0), sideways(1)));
  EXPECT_GT(frontend.report().tracked, 0.95 * first);
}

bool same(const std::vector<FeatureFrame>& a, const std::vector<FeatureFrame>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
    return p.time == q.time &&
           std::equal(p.pixels.begin(), p.pixels.end(), q.pixels.begin(), q.pixels.end(),
                      [](const PixelObservation& x, const PixelObservation& y) {
                        return x.landmark == y.landmark && x.camera == y.camera &&
                               x.pixel == y.pixel;
                      });
  });
}

TEST(Frontend, GivesTheSameBytesEachTime) {
  Walk walk{.rig = euroc_rig(), .frames = 6, .settings = {.equalisation = Equalisation::kClahe}};
  const auto one = follow(walk).features;
  EXPECT_TRUE(same(one, follow(walk).features));
  walk.settings.max_tracks = 149;
  EXPECT_FALSE(same(one, follow(walk).features));
}

}  // namespace
}  // namespace chasles::test
