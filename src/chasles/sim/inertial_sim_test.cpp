#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_imu.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/inertial_sim_testing.hpp>
#include <chasles/sim/inertial_world.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::hallway;
using test::kSigmas;
using test::walk;

// One section and its turn, without errors in the images.
InertialScene exact() {
  InertialScene scene = hallway();
  scene.settings.sections = 1;
  scene.settings.pixel_sigma = 0;
  return scene;
}

std::map<LandmarkId, Vector3d> positions(const Recording& recording) {
  std::map<LandmarkId, Vector3d> result;
  for (const auto& landmark : recording.true_landmarks) result[landmark.id] = landmark.p_world;
  return result;
}

// Calls visit(frame, observation, expected pixel), the latter by the pinhole's formula.
void for_each_observation(
    const Recording& recording,
    const std::function<void(std::size_t, const PixelObservation&, const Vector2d&)>& visit) {
  const auto landmarks = positions(recording);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    for (const auto& seen : recording.frames[i].pixels) {
      const Camera& camera = recording.cameras.at(static_cast<std::size_t>(seen.camera));
      const Vector3d p =
          camera.cam_T_imu * (recording.truth[i].pose.inverse() * landmarks.at(seen.landmark));
      visit(i, seen,
            {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy});
    }
  }
}

// For every landmark the frames with an observation of it.
std::map<LandmarkId, std::vector<std::size_t>> lives(const Recording& recording) {
  std::map<LandmarkId, std::vector<std::size_t>> result;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    for (const auto& seen : recording.frames[i].pixels) {
      auto& frames = result[seen.landmark];
      if (frames.empty() || frames.back() != i) frames.push_back(i);
    }
  }
  return result;
}

void expect_fraction(double found, double count, double fraction) {
  EXPECT_NEAR(found, count * fraction, kSigmas * std::sqrt(count * fraction * (1 - fraction)));
}

TEST(InertialSim, TheWalkIsThePapersSensorSystem) {
  const Recording& recording = walk();
  EXPECT_NEAR(to_seconds(recording.frames.back().time), 71, 1);
  EXPECT_NEAR(static_cast<double>(recording.frames.size()), 71 * 28, 28);
  EXPECT_EQ(recording.imu[100].time, std::chrono::seconds(1));
  EXPECT_GE(recording.frames.back().time - recording.imu.back().time, Time(-40'000'000));
  EXPECT_EQ(recording.cameras.at(0).width, 699);
  EXPECT_EQ(recording.single_pixel_sigma, 1.0);
  EXPECT_EQ(recording.imu_noise.value().gyroscope_noise_density, 9.774e-5);
  EXPECT_EQ(recording.imu_convention, ImuConvention::kInstant);
  EXPECT_TRUE(recording.velocities.empty());
}

TEST(InertialSim, TruthIsGivenAtEveryFrame) {
  const Recording& recording = walk();
  const Spline motion = inertial_motion(hallway());
  ASSERT_EQ(recording.truth.size(), recording.frames.size());
  ASSERT_EQ(recording.true_motion.size(), recording.frames.size());
  for (std::size_t i = 0; i < recording.frames.size(); i += 17) {
    EXPECT_EQ(recording.truth[i].time, recording.frames[i].time);
    EXPECT_EQ(recording.true_motion[i].time, recording.frames[i].time);
    const Motion now = motion_at(motion, to_seconds(recording.frames[i].time));
    EXPECT_EQ(recording.truth[i].pose.p, now.world_T_imu.p);
    EXPECT_EQ(recording.true_motion[i].v_world, now.v_world);
  }
}

TEST(InertialSim, TheTrueBiasesAreThoseInTheSamples) {
  InertialScene scene = hallway();
  scene.settings.accelerometer_noise_density = scene.settings.gyroscope_noise_density = 0;
  scene.settings.frame_rate = 50;
  const Recording recording = simulate_inertial(scene, 2);
  const auto ideal = ideal_imu(inertial_motion(scene), 100, ImuConvention::kInstant);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const ImuSample& sample = recording.imu[2 * i];
    ASSERT_EQ(sample.time, recording.frames[i].time);
    const Vector3d bias_f = sample.specific_force_imu - ideal[2 * i].specific_force_imu;
    const Vector3d bias_w = sample.angular_rate_imu - ideal[2 * i].angular_rate_imu;
    EXPECT_LT((bias_f - recording.true_motion[i].accelerometer_bias).norm(), 1e-13);
    EXPECT_LT((bias_w - recording.true_motion[i].gyroscope_bias).norm(), 1e-13);
  }
}

TEST(InertialSim, PixelsAreProjectionsWithNoiseOfOnePixel) {
  double sum = 0, count = 0, neighbours = 0;
  std::map<LandmarkId, Vector2d> last;
  for_each_observation(walk(), [&](auto, const auto& seen, const Vector2d& expected) {
    const Vector2d error = seen.pixel - expected;
    sum += error.squaredNorm();
    count += 2;
    const auto before = last.find(seen.landmark);
    if (before != last.end()) neighbours += error.dot(before->second);
    last[seen.landmark] = error;
  });
  EXPECT_NEAR(sum, count, kSigmas * std::sqrt(2 * count));
  EXPECT_LT(std::abs(neighbours), kSigmas * std::sqrt(count));
  for_each_observation(simulate_inertial(exact()),
                       [&](auto, const auto& seen, const Vector2d& expected) {
                         ASSERT_LT((seen.pixel - expected).norm(), 1e-9);
                       });
}

TEST(InertialSim, TracksAreKeptUpAndNeverInterrupted) {
  const Recording& recording = walk();
  std::size_t full = 0;
  for (const auto& frame : recording.frames) {
    EXPECT_LE(frame.pixels.size(), 35U);
    EXPECT_GE(frame.pixels.size(), 12U);
    full += frame.pixels.size() == 35;
  }
  EXPECT_GT(static_cast<double>(full), 0.9 * static_cast<double>(recording.frames.size()));
  for (const auto& [landmark, frames] : lives(recording)) {
    EXPECT_EQ(frames.back() - frames.front() + 1, frames.size()) << landmark;
  }
}

TEST(InertialSim, ATrackEndsOnlyWhereItsLandmarkIsLost) {
  const InertialScene scene = exact();
  const Recording recording = simulate_inertial(scene);
  const auto landmarks = positions(recording);
  const Camera& camera = recording.cameras[0];
  for (const auto& [landmark, frames] : lives(recording)) {
    const std::size_t next = frames.back() + 1;
    if (next == recording.frames.size()) continue;
    const Vector3d p =
        camera.cam_T_imu * (recording.truth[next].pose.inverse() * landmarks.at(landmark));
    const Vector2d pixel(480 * p.x() / p.z() + 349.5, 480 * p.y() / p.z() + 270);
    const bool inside = p.z() > 0 && p.norm() > 0.8 && p.norm() < 15 && pixel.x() > 5 &&
                        pixel.y() > 5 && pixel.x() < 694 - 1 && pixel.y() < 535 - 1;
    EXPECT_FALSE(inside) << landmark;  // the turn leads away from every edge of the block
  }
}

TEST(InertialSim, NoTrackIsShorterThanAskedFor) {
  const Recording& recording = walk();
  for (const auto& [landmark, frames] : lives(recording)) {
    if (frames.back() + 1 == recording.frames.size()) continue;
    EXPECT_GE(frames.size(), 2U) << landmark;
  }
  InertialScene scene = exact();
  scene.settings.shortest_track = 40;
  double shorter = 0, all = 0;
  for (const auto& [landmark, frames] : lives(simulate_inertial(scene))) {
    ++all;
    shorter += frames.size() < 40;
  }
  EXPECT_LT(shorter, 0.25 * all);  // occluded in between, or started near the end
}

TEST(InertialSim, ALandmarkThatReturnsIsNewUnlessItKeepsItsNumber) {
  InertialScene scene = hallway();
  scene.settings.sections = 5;  // the first section twice
  scene.settings.pixel_sigma = 0;
  const auto points = [](const Recording& recording) {
    std::set<std::pair<double, double>> result;
    for (const auto& landmark : recording.true_landmarks) {
      result.emplace(landmark.p_world.x(), landmark.p_world.y());
    }
    return result.size();
  };
  const Recording fresh = simulate_inertial(scene);
  EXPECT_LT(points(fresh), fresh.true_landmarks.size() - 20);
  scene.settings.keep_ids = true;
  const Recording kept = simulate_inertial(scene);
  EXPECT_EQ(points(kept), kept.true_landmarks.size());
  bool returned = false;
  for (const auto& [landmark, frames] : lives(kept)) {
    returned |= frames.back() - frames.front() + 1 > frames.size() + 1000;
  }
  EXPECT_TRUE(returned);
}

TEST(InertialSim, TheTurntablesLandmarksAreAllSeenFromTheFirstFrameToTheLast) {
  const Recording recording = simulate_inertial(inertial_scene("turntable"));
  ASSERT_EQ(recording.true_landmarks.size(), 40U);
  for (const auto& frame : recording.frames) {
    ASSERT_EQ(frame.pixels.size(), 40U);
    for (int i = 0; i < 40; ++i) {
      ASSERT_EQ(frame.pixels[static_cast<std::size_t>(i)].landmark, i);
    }
  }
  for (std::size_t i = 0; i < recording.truth.size(); i += 10) {
    const SE3 cam_T_world = recording.cameras[0].cam_T_imu * recording.truth[i].pose.inverse();
    for (const auto& landmark : recording.true_landmarks) {
      const double depth = (cam_T_world * landmark.p_world).z();
      EXPECT_GT(depth, 4.5);
      EXPECT_LT(depth, 12);
    }
  }
}

TEST(InertialSim, LandmarksBeyondTheCapWait) {
  InertialScene scene = exact();
  scene.settings.landmarks_in_view = 7;
  for (const auto& frame : simulate_inertial(scene).frames) EXPECT_LE(frame.pixels.size(), 7U);
}

TEST(InertialSim, TwoCamerasShareTheLandmarks) {
  InertialScene scene = exact();
  scene.settings.cameras = 2;
  const Recording recording = simulate_inertial(scene);
  std::size_t both = 0, one = 0;
  for (const auto& frame : recording.frames) {
    std::map<LandmarkId, std::set<int>> seen;
    for (const auto& pixel : frame.pixels) {
      EXPECT_TRUE(seen[pixel.landmark].insert(pixel.camera).second);
    }
    EXPECT_LE(seen.size(), 35U);
    for (const auto& [landmark, by] : seen) ++(by.size() == 2 ? both : one);
  }
  EXPECT_GT(both, 5 * one);
  EXPECT_GT(one, 0U);
  for_each_observation(recording, [](auto, const auto& seen, const Vector2d& expected) {
    ASSERT_LT((seen.pixel - expected).norm(), 1e-9);
  });
}

// Steps of variance drift^2 dt, the same in both cameras, from zero at the first observation.
TEST(InertialSim, OfARingEachCameraHasTracksThatItFound) {
  InertialScene scene = hallway();
  scene.settings.cameras = 4;
  scene.settings.rig = RigLayout::kRing;
  scene.settings.landmarks_in_view = 120;
  scene.settings.sections = 1;
  std::map<LandmarkId, int> finder;
  std::array<int, 4> found{};
  for (const FeatureFrame& frame : simulate_inertial(scene).frames) {
    for (const PixelObservation& o : frame.pixels) {
      ASSERT_TRUE(o.match.has_value());
      if (*o.match) continue;
      ++found[static_cast<std::size_t>(o.camera)];
      EXPECT_EQ(finder.try_emplace(o.landmark, o.camera).first->second, o.camera);
    }
  }
  for (const int n : found) EXPECT_GT(n, 1000);
  scene.settings.rig = RigLayout::kSideBySide;
  scene.settings.cameras = 2;
  for (const FeatureFrame& frame : simulate_inertial(scene).frames) {
    for (const PixelObservation& o : frame.pixels) ASSERT_FALSE(o.match.has_value());
  }
}

TEST(InertialSim, TracksDriftAlikeInAllCameras) {
  constexpr double kDrift = 2;
  InertialScene scene = exact();
  scene.settings.cameras = 2;
  scene.settings.track_drift = kDrift;
  const Recording recording = simulate_inertial(scene);
  std::map<LandmarkId, std::map<std::size_t, std::vector<Vector2d>>> tracks;
  for_each_observation(recording, [&](auto frame, const auto& seen, const Vector2d& expected) {
    tracks[seen.landmark][frame].push_back(seen.pixel - expected);
  });
  double sum = 0, count = 0;
  for (const auto& [landmark, errors] : tracks) {
    EXPECT_LT(errors.begin()->second.front().norm(), 1e-9);
    for (auto now = errors.begin(); now != errors.end(); ++now) {
      EXPECT_LT((now->second.back() - now->second.front()).norm(), 1e-9);
      if (now == errors.begin()) continue;
      const auto before = std::prev(now);
      const double dt =
          to_seconds(recording.frames[now->first].time - recording.frames[before->first].time);
      sum += (now->second.front() - before->second.front()).squaredNorm() / dt;
      count += 2;
    }
  }
  EXPECT_GT(count, 5000);
  EXPECT_NEAR(sum, kDrift * kDrift * count, kSigmas * kDrift * kDrift * std::sqrt(2 * count));
}

// Of the second camera only, and the same in all frames.
TEST(InertialSim, MatchesHaveAConstantErrorAlongATrack) {
  constexpr double kSigma = 0.5;
  InertialScene scene = exact();
  scene.settings.cameras = 2;
  scene.settings.match_sigma = kSigma;
  std::map<LandmarkId, Vector2d> errors;
  for_each_observation(simulate_inertial(scene),
                       [&](auto, const auto& seen, const Vector2d& expected) {
                         const Vector2d error = seen.pixel - expected;
                         if (seen.camera == 0) {
                           EXPECT_LT(error.norm(), 1e-9);
                           return;
                         }
                         const Vector2d first = errors.emplace(seen.landmark, error).first->second;
                         EXPECT_LT((error - first).norm(), 1e-9);
                       });
  double sum = 0;
  for (const auto& [landmark, error] : errors) sum += error.squaredNorm();
  const double count = 2 * static_cast<double>(errors.size());
  EXPECT_GT(count, 200);
  EXPECT_NEAR(sum, kSigma * kSigma * count, kSigmas * kSigma * kSigma * std::sqrt(2 * count));
}

TEST(InertialSim, OutliersAreAsManyAsAskedForAndLieAnywhere) {
  InertialScene scene = exact();
  scene.settings.outlier_fraction = 0.1;
  double count = 0, outliers = 0;
  Vector2d mean = Vector2d::Zero();
  for_each_observation(simulate_inertial(scene),
                       [&](auto, const auto& seen, const Vector2d& expected) {
                         ++count;
                         if ((seen.pixel - expected).norm() < 1e-6) return;
                         ++outliers;
                         mean += seen.pixel;
                       });
  expect_fraction(outliers, count, 0.1);
  const Eigen::Array2d size(699, 540);
  const Eigen::Array2d off = (mean.array() / outliers - size / 2).abs();
  EXPECT_TRUE((off < kSigmas * size / std::sqrt(12 * outliers)).all());
}

TEST(InertialSim, DroppedFramesAreEmptyAndTracksGoOnAfterThem) {
  InertialScene scene = hallway();
  scene.settings.dropped_fraction = 0.1;
  const Recording recording = simulate_inertial(scene);
  double dropped = 0;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const auto& pixels = recording.frames[i].pixels;
    if (pixels.empty()) {
      ++dropped;
      continue;
    }
    ASSERT_EQ(pixels.size(), walk().frames[i].pixels.size());
    EXPECT_EQ(pixels[3].landmark, walk().frames[i].pixels[3].landmark);
    EXPECT_EQ(pixels[3].pixel, walk().frames[i].pixels[3].pixel);
  }
  expect_fraction(dropped, static_cast<double>(recording.frames.size()), 0.1);
}

InertialScene given_path() {
  InertialScene scene = inertial_scene("trajectory");
  for (int i = 0; i <= 2000; ++i) {
    const double t = 0.01 * i;
    scene.path.push_back(
        {from_seconds(1e9 + t), {so3::exp({0, 0.1 * std::sin(t), 0.3 * t}), {t, std::sin(t), 1}}});
  }
  return scene;
}

TEST(InertialSim, AGivenTrajectoryIsFollowedInItsOwnTime) {
  const InertialScene scene = given_path();
  const Recording recording = simulate_inertial(scene);
  EXPECT_EQ(recording.frames.front().time, scene.path.front().time);
  EXPECT_EQ(recording.imu.front().time, scene.path.front().time);
  EXPECT_EQ(recording.imu.back().time, scene.path.back().time);
  for (std::size_t i = 28; i + 28 < recording.truth.size(); i += 28) {
    const auto at = std::ranges::find(scene.path, recording.truth[i].time, &StampedPose::time);
    ASSERT_NE(at, scene.path.end());
    EXPECT_TRUE(test::agree(recording.truth[i].pose.p, at->pose.p, 1e-4));
    EXPECT_TRUE(test::agree(recording.truth[i].pose.R, at->pose.R, 1e-4));
  }
  for (const auto& frame : recording.frames) {
    EXPECT_GE(frame.pixels.size(), 30U);
    EXPECT_LE(frame.pixels.size(), 75U);
  }
}

TEST(InertialSim, RealSamplesAndCamerasAreTakenAsTheyAre) {
  InertialScene scene = given_path();
  for (int i = 0; i < 200; ++i) {
    scene.imu.push_back({.time = scene.path[500].time + from_seconds(0.005 * i),
                         .specific_force_imu = Vector3d(i, 0, 0)});
  }
  scene.cameras = {{.width = 320,
                    .height = 240,
                    .fx = 200,
                    .fy = 210,
                    .cx = 160,
                    .cy = 120,
                    .cam_T_imu = make_cameras(scene.settings)[0].cam_T_imu}};
  const Recording recording = simulate_inertial(scene);
  EXPECT_EQ(recording.imu.size(), 200U);
  EXPECT_EQ(recording.imu[7].specific_force_imu.x(), 7);
  EXPECT_TRUE(recording.true_motion.empty());
  EXPECT_GE(recording.frames.front().time, scene.imu.front().time);
  EXPECT_LE(recording.frames.back().time, scene.imu.back().time);
  EXPECT_EQ(recording.frames.size(), 28U);
  EXPECT_EQ(recording.cameras.at(0).fy, 210);
  scene.imu.assign(1, {.time = Time(5)});
  EXPECT_THROW(simulate_inertial(scene), UsageError);
}

TEST(InertialSim, TooManyFramesAreRejected) {
  InertialScene scene = hallway();
  scene.settings.sections = 60;
  scene.settings.frame_rate = 1000;
  scene.settings.knot_interval = 0.2;
  EXPECT_THROW(simulate_inertial(scene), UsageError);
}

}  // namespace
}  // namespace chasles
