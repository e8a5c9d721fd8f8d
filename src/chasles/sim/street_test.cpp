#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/sim/street.hpp>
#include <chasles/sim/street_drive.hpp>
#include <chasles/sim/street_world.hpp>

namespace chasles {
namespace {

constexpr double kStreetSigmas = 4;  // of the statistic under test; the seeds are fixed

const Recording& noisy() {
  static const Recording recording = simulate_street({});
  return recording;
}
const Recording& exact_street() {
  static const Recording recording = simulate_street(street_scene("street-exact"));
  return recording;
}

std::map<LandmarkId, Eigen::Vector3d> street_positions(const Recording& recording) {
  std::map<LandmarkId, Eigen::Vector3d> result;
  for (const auto& landmark : recording.true_landmarks) result[landmark.id] = landmark.p_world;
  return result;
}

// The pixels of a point at a true pose: Du, eq. 2, as a separate implementation.
Eigen::Vector4d expected_pixels(const Recording& recording, const SE3& world_T_imu,
                                const Eigen::Vector3d& p_world) {
  const StereoRig& rig = recording.rig;
  const Eigen::Vector3d p = rig.cam0_T_imu * (world_T_imu.inverse() * p_world);
  const double v = rig.fy * p.y() / p.z() + rig.cy;
  return {rig.fx * p.x() / p.z() + rig.cx, v, rig.fx * (p.x() - rig.baseline) / p.z() + rig.cx, v};
}

// Calls visit(frame, observation, expected pixels) for every observation of a static landmark.
void for_each_street_observation(const Recording& recording,
                                 const std::function<void(std::size_t, const StereoObservation&,
                                                          const Eigen::Vector4d&)>& visit) {
  const auto landmarks = street_positions(recording);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    for (const auto& observation : recording.frames[i].observations) {
      const auto landmark = landmarks.find(observation.landmark);
      if (landmark == landmarks.end()) continue;
      visit(i, observation, expected_pixels(recording, recording.truth[i].pose, landmark->second));
    }
  }
}

void expect_street_variance(double sum_of_squares, double count, double sigma) {
  EXPECT_NEAR(sum_of_squares / (sigma * sigma), count, kStreetSigmas * std::sqrt(2 * count));
}

void expect_street_fraction(double found, double count, double fraction) {
  EXPECT_NEAR(found, count * fraction,
              kStreetSigmas * std::sqrt(count * fraction * (1 - fraction)));
}

std::string bytes(const Recording& recording) {
  std::string result;
  const auto add = [&](const auto& value) {
    result.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const auto& velocity : recording.velocities) add(velocity);
  for (const auto& frame : recording.frames) {
    add(frame.time);
    for (const auto& observation : frame.observations) {
      add(observation.landmark);
      for (const double x : observation.pixels) add(x);
    }
  }
  for (const auto& landmark : recording.true_landmarks) {
    add(landmark.id);
    for (const double x : landmark.p_world) add(x);
  }
  return result;
}

TEST(Street, ADriveOfSevenHundredMetresInTwoMinutes) {
  double length = 0;
  for (std::size_t i = 1; i < noisy().truth.size(); ++i) {
    length += (noisy().truth[i].pose.p - noisy().truth[i - 1].pose.p).norm();
  }
  EXPECT_NEAR(length, 700, 10);
  EXPECT_NEAR(to_seconds(noisy().frames.back().time), 125, 10);
}

TEST(Street, FramesTruthAndVelocitiesShareTheirTimes) {
  const Recording& recording = noisy();
  ASSERT_EQ(recording.frames.size(), recording.truth.size());
  ASSERT_EQ(recording.frames.size(), recording.velocities.size());
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    EXPECT_EQ(recording.frames[i].time, i * std::chrono::milliseconds(100));
    EXPECT_EQ(recording.frames[i].time, recording.truth[i].time);
    EXPECT_EQ(recording.frames[i].time, recording.velocities[i].time);
  }
}

TEST(Street, VelocitiesCanBeFasterThanFrames) {
  const Recording fast = simulate_street({.velocities_per_frame = 10});
  ASSERT_EQ(fast.velocities.size(), 10 * (fast.frames.size() - 1) + 1);
  EXPECT_EQ(fast.velocities[10].time, fast.frames[1].time);
  EXPECT_EQ(fast.velocities.back().time, fast.frames.back().time);
}

TEST(Street, TheRigIsARigidMotionWithTheCameraWhereTheSettingsPutIt) {
  const SE3 imu_T_cam0 = noisy().rig.cam0_T_imu.inverse();
  EXPECT_TRUE((imu_T_cam0.R * imu_T_cam0.R.transpose()).isIdentity(1e-14));
  EXPECT_GT(imu_T_cam0.R.col(0).cross(imu_T_cam0.R.col(1)).dot(imu_T_cam0.R.col(2)), 0);
  EXPECT_TRUE(imu_T_cam0.p.isApprox(Eigen::Vector3d(1.1439, -0.3127, 0.7265), 1e-12));
  EXPECT_GT(imu_T_cam0.R(0, 2), 0.999);   // points forward
  EXPECT_LT(imu_T_cam0.R(1, 0), -0.999);  // its x is to the right
  EXPECT_LT(imu_T_cam0.R(2, 1), -0.999);  // its y is down
  // KITTI's camera is tilted up by half a degree: the tilt about y is positive, the axis's z
  // negative.
  EXPECT_NEAR(imu_T_cam0.R(2, 2), -0.0085, 1e-4);
}

TEST(Street, ExactPixelsAreTheProjectionsOfTheTrueLandmarks) {
  std::size_t count = 0;
  for_each_street_observation(
      exact_street(), [&](auto, const auto& observation, const auto& expected) {
        ASSERT_LT((observation.pixels - expected).cwiseAbs().maxCoeff(), 1e-9);
        ++count;
      });
  EXPECT_GT(count, 80'000U);
}

TEST(Street, WhatIsSeenLiesInBothImagesAndInRange) {
  const double depth_times_disparity = exact_street().rig.fx * exact_street().rig.baseline;
  for_each_street_observation(exact_street(), [&](auto, const auto& observation, const auto&) {
    const Eigen::Vector4d& z = observation.pixels;
    const double depth = depth_times_disparity / (z[0] - z[2]);
    ASSERT_GE(std::min({z[0], z[1], z[2], z[3]}), 5);
    ASSERT_LE(std::max(z[0], z[2]), 1240 - 5);
    ASSERT_LE(std::max(z[1], z[3]), 375 - 5);
    ASSERT_GE(depth, 2.5 - 1e-9);
    ASSERT_LE(depth, 60 + 1e-9);
  });
}

TEST(Street, ExactVelocitiesIntegrateToTheTruth) {
  StreetSettings settings = street_scene("street-exact");
  settings.velocities_per_frame = 100;
  settings.features_per_frame = 0;
  const Recording recording = simulate_street(settings);
  const auto twist = [&](std::size_t i) {
    Vector6d xi;
    xi << recording.velocities[i].angular_imu, recording.velocities[i].linear_imu;
    return xi;
  };
  SE3 pose = recording.truth.front().pose;
  for (std::size_t i = 0; i + 1 < recording.velocities.size(); ++i) {
    const double tau = to_seconds(recording.velocities[i + 1].time - recording.velocities[i].time);
    pose = pose * se3::exp(tau / 2 * (twist(i) + twist(i + 1)));
    if ((i + 1) % 100 == 0) {
      ASSERT_LT((pose.p - recording.truth[(i + 1) / 100].pose.p).norm(), 1e-3) << i;
    }
  }
}

TEST(Street, AboutSeventyFeaturesAreSeenInEveryFrame) {
  for (const auto& frame : noisy().frames) {
    EXPECT_GE(frame.observations.size(), 50U);
    EXPECT_LE(frame.observations.size(), 90U);
  }
}

TEST(Street, ALandmarkThatLeftNeverComesBack) {
  std::map<LandmarkId, std::pair<std::size_t, std::size_t>> span;  // first frame, number of frames
  for (std::size_t i = 0; i < noisy().frames.size(); ++i) {
    LandmarkId before = -1;
    for (const auto& observation : noisy().frames[i].observations) {
      EXPECT_GT(observation.landmark, before);  // each once, in rising order
      before = observation.landmark;
      auto& [first, count] = span.try_emplace(observation.landmark, i, 0).first->second;
      ASSERT_EQ(first + count, i) << "landmark " << observation.landmark;
      ++count;
    }
  }
  EXPECT_EQ(span.size(), noisy().true_landmarks.size());
  std::vector<std::size_t> lengths;
  for (const auto& [id, track] : span) lengths.push_back(track.second);
  std::ranges::nth_element(lengths, lengths.begin() + lengths.size() / 2);
  EXPECT_NEAR(static_cast<double>(lengths[lengths.size() / 2]), 12, 4);  // as in ECE276A 2020/0027
}

TEST(Street, LandmarksStandOnFacadesAndOnTheRoad) {
  std::size_t road = 0, facade = 0;
  for (const auto& landmark : noisy().true_landmarks) {
    const Eigen::Vector3d& p = landmark.p_world;
    // A façade is 10 m off the middle of a street; streets are 100 and 80 m apart.
    const double x = std::abs(std::remainder(p.x(), 100)), y = std::abs(std::remainder(p.y(), 80));
    if (std::abs(x - 10) < 1e-9 || std::abs(y - 10) < 1e-9) {
      ++facade;
    } else {
      ASSERT_LT(std::abs(p.z() + 0.93), 2 * 0.15 + 1e-9) << landmark.id;
      ++road;
    }
  }
  EXPECT_GT(facade, 2000U);
  EXPECT_GT(road, 1000U);
}

TEST(Street, NothingIsSeenThroughAHouse) {
  // To a camera that moves forward, houses only uncover static points; they occlude moving ones as
  // well.
  StreetSettings settings = street_scene("street-exact");
  settings.moving_fraction = 0.5;
  const StreetWorld world = make_street_world(settings, make_street_drive(settings));
  const Recording recording = simulate_street(settings);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const SE3 world_T_cam0 = recording.truth[i].pose * recording.rig.cam0_T_imu.inverse();
    for (const auto& [id, pixels] : recording.frames[i].observations) {
      const Eigen::Vector3d p = world_T_cam0 * triangulate(recording.rig, pixels).value().p_cam0;
      ASSERT_FALSE(blocked(world, world_T_cam0.p, p)) << "landmark " << id << ", frame " << i;
    }
  }
}

TEST(Street, TracksWithoutALifeOfTheirOwnLastForTheShortestTrack) {
  const Recording recording = simulate_street({.track_life = 0.01, .shortest_track = 4});
  std::map<LandmarkId, int> lengths;
  for (const auto& frame : recording.frames) {
    for (const auto& observation : frame.observations) ++lengths[observation.landmark];
  }
  const auto as_asked =
      std::ranges::count(lengths, 4, [](const auto& entry) { return entry.second; });
  EXPECT_GT(static_cast<double>(as_asked), 0.98 * static_cast<double>(lengths.size()));
}

TEST(Street, VelocityNoiseAndBiasAreThoseOfTheSettings) {
  const Eigen::Vector3d bias(0.003, -0.004, 0.007);
  const auto n = static_cast<double>(noisy().velocities.size());
  double linear = 0, angular = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < noisy().velocities.size(); ++i) {
    const BodyVelocity& found = noisy().velocities[i];
    const BodyVelocity& truth = exact_street().velocities[i];
    linear += (found.linear_imu - truth.linear_imu).squaredNorm();
    angular += (found.angular_imu - truth.angular_imu - bias).squaredNorm();
    mean += (found.angular_imu - truth.angular_imu) / n;
  }
  expect_street_variance(linear, 3 * n, 0.5);
  expect_street_variance(angular, 3 * n, 0.05);
  EXPECT_LT((mean - bias).cwiseAbs().maxCoeff(), kStreetSigmas * 0.05 / std::sqrt(n));
  EXPECT_GT(mean.norm(), kStreetSigmas * 0.05 / std::sqrt(n));
}

TEST(Street, TheVelocityScaleStretchesTheLinearVelocityOnly) {
  StreetSettings settings = street_scene("street-exact");
  settings.velocity_scale = 1.03;
  const Recording scaled = simulate_street(settings);
  for (std::size_t i = 0; i < scaled.velocities.size(); ++i) {
    const Eigen::Vector3d expected = 1.03 * exact_street().velocities[i].linear_imu;
    ASSERT_LT((scaled.velocities[i].linear_imu - expected).norm(), 1e-12);
    ASSERT_EQ(scaled.velocities[i].angular_imu, exact_street().velocities[i].angular_imu);
  }
}

TEST(Street, PixelNoiseIsWhiteAndHasTheSigmaOfTheSettings) {
  StreetSettings settings = street_scene("street-exact");
  settings.pixel_sigma = 0.5;
  const Recording recording = simulate_street(settings);
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  double count = 0, lagged = 0, pairs = 0;
  std::map<LandmarkId, Eigen::Vector4d> before;
  for_each_street_observation(recording, [&](auto, const auto& observation, const auto& expected) {
    const Eigen::Vector4d e = observation.pixels - expected;
    sum += e * e.transpose();
    ++count;
    const auto last = before.find(observation.landmark);
    if (last != before.end()) {
      lagged += e.dot(last->second);
      pairs += 4;
    }
    before[observation.landmark] = e;
  });
  const double variance = 0.25;
  for (int i = 0; i < 4; ++i) {
    expect_street_variance(sum(i, i), count, 0.5);
    for (int j = 0; j < i; ++j) {
      EXPECT_LT(std::abs(sum(i, j)), kStreetSigmas * variance * std::sqrt(count)) << i << ", " << j;
    }
  }
  EXPECT_LT(std::abs(lagged), kStreetSigmas * variance * std::sqrt(pairs));
}

TEST(Street, ADisparityErrorStaysTheSameAlongItsTrack) {
  StreetSettings settings = street_scene("street-exact");
  settings.disparity_sigma = 0.6;
  const Recording recording = simulate_street(settings);
  std::map<LandmarkId, double> errors;
  for_each_street_observation(recording, [&](auto, const auto& observation, const auto& expected) {
    const Eigen::Vector4d e = observation.pixels - expected;
    ASSERT_LT(std::max({std::abs(e[0]), std::abs(e[1]), std::abs(e[3])}), 1e-9);
    const double first = errors.try_emplace(observation.landmark, e[2]).first->second;
    ASSERT_NEAR(e[2], first, 1e-9);
  });
  double sum = 0;
  for (const auto& [id, error] : errors) sum += error * error;
  expect_street_variance(sum, static_cast<double>(errors.size()), 0.6);
}

TEST(Street, OutliersAreAsManyAsAskedForAndLieAnywhere) {
  StreetSettings settings = street_scene("street-exact");
  settings.outlier_fraction = 0.1;
  const Recording recording = simulate_street(settings);
  double count = 0, outliers = 0;
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  for_each_street_observation(recording, [&](auto, const auto& observation, const auto& expected) {
    ++count;
    if ((observation.pixels - expected).norm() < 1e-6) return;
    ++outliers;
    mean += observation.pixels;
  });
  expect_street_fraction(outliers, count, 0.1);
  const Eigen::Array4d size(1241, 376, 1241, 376);
  const Eigen::Array4d off = (mean.array() / outliers - size / 2).abs();
  EXPECT_TRUE((off < kStreetSigmas * size / std::sqrt(12 * outliers)).all());
}

TEST(Street, MovingThingsMoveAndAreNoLandmarks) {
  StreetSettings settings = street_scene("street-exact");
  settings.moving_fraction = 0.2;
  const Recording recording = simulate_street(settings);
  const auto standing = street_positions(recording);
  std::map<LandmarkId, Eigen::Vector3d> last;
  std::set<LandmarkId> moving;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    const SE3 world_T_cam0 = recording.truth[i].pose * recording.rig.cam0_T_imu.inverse();
    for (const auto& [id, pixels] : recording.frames[i].observations) {
      if (standing.contains(id)) continue;
      moving.insert(id);
      const Eigen::Vector3d p = world_T_cam0 * triangulate(recording.rig, pixels).value().p_cam0;
      if (last.contains(id)) {
        ASSERT_NEAR((p - last[id]).norm(), 6 * 0.1, 1e-6);
      }
      last[id] = p;
    }
  }
  expect_street_fraction(static_cast<double>(moving.size()),
                         static_cast<double>(moving.size() + standing.size()), 0.2);
}

TEST(Street, DroppedFramesAreEmptyAndEndAllTracks) {
  StreetSettings settings = street_scene("street-exact");
  settings.dropped_fraction = 0.1;
  const Recording recording = simulate_street(settings);
  double dropped = 0;
  LandmarkId newest = -1, oldest_allowed = 0;
  for (const auto& frame : recording.frames) {
    if (frame.observations.empty()) {
      ++dropped;
      oldest_allowed = newest + 1;
      continue;
    }
    EXPECT_GE(frame.observations.front().landmark, oldest_allowed);
    newest = frame.observations.back().landmark;
  }
  expect_street_fraction(dropped, static_cast<double>(recording.frames.size()), 0.1);
}

TEST(Street, SameSettingsGiveTheSameBytesAndAnotherSeedDoesNot) {
  EXPECT_EQ(bytes(simulate_street({})), bytes(noisy()));
  const Recording other = simulate_street({.seed = 2});
  EXPECT_NE(bytes(other), bytes(noisy()));
  EXPECT_NE(other.velocities[0].linear_imu, noisy().velocities[0].linear_imu);
  EXPECT_NE(other.frames[0].observations[0].pixels, noisy().frames[0].observations[0].pixels);
}

TEST(Street, OneSourceOfNoiseDoesNotDisturbAnother) {
  const Recording calm = simulate_street({.linear_sigma = 0});
  for (std::size_t i = 0; i < calm.velocities.size(); ++i) {
    ASSERT_EQ(calm.velocities[i].angular_imu, noisy().velocities[i].angular_imu);
  }
  EXPECT_EQ(calm.frames[700].observations[5].pixels, noisy().frames[700].observations[5].pixels);
}

}  // namespace
}  // namespace chasles
