#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

#include <chasles/error.hpp>
#include <chasles/frontend/frontend_testing.hpp>

namespace chasles::test {
namespace {

using Path = std::function<SE3(int)>;

double median(std::vector<double> values) {
  if (values.empty()) return 1e9;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// A path through the room that a front end follows.
struct Walk {
  std::vector<Camera> rig = {euroc_rig()[0]};
  Path path = walk_pose;
  int frames = 12;
  bool gyroscope = true;
  FrontendSettings settings = {};
};

/// What came of it, held against the truth.
struct Outcome {
  std::vector<FeatureFrame> features;
  std::vector<FrontendReport> reports;
  std::vector<double> step_errors;   ///< from a frame to the next [px]
  std::vector<double> total_errors;  ///< from a track's first frame to the last one [px]
  double tracked_share = 0;          ///< of the points that stay in the image, each step
};

ImageFrame frame_of(const Walk& walk, int k) {
  return render_frame(room(), walk.rig, walk.path(k), from_seconds(1 + 0.05 * k));
}

std::map<LandmarkId, Eigen::Vector2d> of_camera(const FeatureFrame& features, int camera) {
  std::map<LandmarkId, Eigen::Vector2d> pixels;
  for (const PixelObservation& o : features.pixels) {
    if (o.camera == camera) pixels[o.landmark] = o.pixel;
  }
  return pixels;
}

Outcome follow(const Walk& walk) {
  Outcome out;
  Frontend frontend(walk.settings, walk.rig);
  const Camera& camera = walk.rig[0];
  const auto pose = [&](int k) { return walk.path(k) * camera.cam_T_imu.inverse(); };
  std::map<LandmarkId, Eigen::Vector2d> last;
  std::map<LandmarkId, std::pair<int, Eigen::Vector2d>> first;
  double stayed = 0, tracked = 0;
  for (int k = 0; k < walk.frames; ++k) {
    const RotationPrior prior =
        k > 0 && walk.gyroscope ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{};
    out.features.push_back(frontend.process(frame_of(walk, k), prior));
    out.reports.push_back(frontend.report());
    const auto now = of_camera(out.features.back(), 0);
    for (const auto& [id, pixel] : last) {
      const auto truth = room().true_pixel(camera, pose(k - 1), pixel, camera, pose(k));
      if (!truth || !in_image(camera, *truth, 12)) continue;
      stayed += 1;
      if (!now.contains(id)) continue;
      tracked += 1;
      out.step_errors.push_back((now.at(id) - *truth).norm());
    }
    for (const auto& [id, pixel] : now) first.try_emplace(id, k, pixel);
    last = now;
  }
  for (const auto& [id, pixel] : last) {
    const auto& [k, begin] = first.at(id);
    const auto truth = room().true_pixel(camera, pose(k), begin, camera, pose(walk.frames - 1));
    if (truth && k < walk.frames - 1) out.total_errors.push_back((pixel - *truth).norm());
  }
  out.tracked_share = tracked / std::max(1.0, stayed);
  return out;
}

SE3 sideways(int k) { return {Eigen::Matrix3d::Identity(), {0.02 * k, 0.01 * k, 0.01 * k}}; }

/// 30 degrees a frame, about an axis that is none of the camera's; the room has walls all around.
SE3 spin(int k) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.15, 0.5).normalized();
  return {so3::exp(k * std::numbers::pi / 6 * axis), {0.1, 0.2, -0.1}};
}

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

TEST(Frontend, DoesNotDriftWhereTheGyroscopeTellsHowPatchesTurn) {
  const auto roll = [](int k) { return SE3{so3::exp(Eigen::Vector3d(0, 0, 0.02 * k)), {0, 0, 0}}; };
  EXPECT_LT(median(follow({.path = roll, .frames = 15}).total_errors), 0.06);
}

// No gyroscope tells how an image grows on the way forward; a patch that is kept does.
TEST(Frontend, KeptPatchesDriftLessWhereTheImageGrows) {
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

// Seen twice as large, another point of the same place is the corner.
TEST(Frontend, ATrackEndsWhereItsPatchIsStretched) {
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
  EXPECT_LT(longest(1.15, ended), 1.25);  // it is looked at in every third image
  EXPECT_GT(longest(1000, ended_without), 1.4);
  EXPECT_GT(ended, ended_without + 50);
}

// A board slides slowly before the wall: a corner that its edge makes with what is behind it is no
// point.
TEST(Frontend, ATrackEndsWhereAnEdgeCoversWhatIsBehindIt) {
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

// In a dark room all patches differ from those that were kept, and from the last image's as much.
TEST(Frontend, NoiseDoesNotEndTracks) {
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
  // A textured board that moves across the image while the rig moves on.
  const Walk walk{.path = sideways, .frames = 8};
  Frontend frontend(walk.settings, walk.rig);
  const GrayImage board = room().render(walk.rig[0], spin(3));
  int on_board = 0, outliers = 0;
  for (int k = 0; k < walk.frames; ++k) {
    ImageFrame frame = frame_of(walk, k);
    const int x0 = 250 + 9 * k, y0 = 120 + 7 * k;  // across what the walls do
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
  for (const char* equalisation : {"none", "histogram", "clahe"}) {
    for (const char* corners : {"harris", "shi-tomasi"}) {
      const Outcome out = follow({.path = sideways,
                                  .frames = 5,
                                  .settings = {.corners = corners, .equalisation = equalisation}});
      EXPECT_GT(out.tracked_share, 0.95) << equalisation << corners;
      EXPECT_LT(median(out.step_errors), 0.1) << equalisation << corners;
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

TEST(Frontend, GivesTheSameBytesEachTimeOnAnyNumberOfThreads) {
  Walk walk{.rig = euroc_rig(), .frames = 6, .settings = {.equalisation = "clahe"}};
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const auto one = follow(walk).features;
  cv::setNumThreads(4);
  const auto four = follow(walk).features;
  const auto again = follow(walk).features;
  cv::setNumThreads(before);
  EXPECT_TRUE(same(one, four));
  EXPECT_TRUE(same(four, again));
  walk.settings.max_tracks = 149;
  EXPECT_FALSE(same(one, follow(walk).features));
}

}  // namespace
}  // namespace chasles::test
