#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <chasles/numeric/random.hpp>
#include <chasles/sim/inertial_sim_testing.hpp>

// The same bytes for the same scene and run, different errors for another run.
namespace chasles {
namespace {

using Eigen::Vector3d;
using test::hallway;
using test::kSigmas;
using test::walk;

template <typename Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append(std::string& bytes, const Vector3d& v) {
  for (const double x : v) append(bytes, x);
}

std::string imu_bytes(const Recording& recording) {
  std::string bytes;
  for (const ImuSample& sample : recording.imu) {
    append(bytes, sample.time);
    append(bytes, sample.specific_force_imu);
    append(bytes, sample.angular_rate_imu);
  }
  return bytes;
}

std::string scene_bytes(const Recording& recording) {
  std::string bytes;
  for (const auto& [time, pose] : recording.truth) {
    append(bytes, time);
    append(bytes, pose.p);
    for (const double x : pose.R.reshaped()) append(bytes, x);
  }
  for (const auto& landmark : recording.true_landmarks) {
    append(bytes, landmark.id);
    append(bytes, landmark.p_world);
  }
  for (const auto& frame : recording.frames) {
    append(bytes, frame.time);
    for (const auto& seen : frame.pixels) append(bytes, seen.landmark);
  }
  return bytes;
}

std::string pixel_bytes(const Recording& recording) {
  std::string bytes;
  for (const auto& frame : recording.frames) {
    for (const auto& seen : frame.pixels) {
      append(bytes, seen.camera);
      append(bytes, seen.pixel.x());
      append(bytes, seen.pixel.y());
    }
  }
  return bytes;
}

std::string bias_bytes(const Recording& recording) {
  std::string bytes;
  for (const TrueMotion& motion : recording.true_motion) {
    append(bytes, motion.accelerometer_bias);
    append(bytes, motion.gyroscope_bias);
  }
  return bytes;
}

TEST(InertialSim, TheSameSceneAndRunGiveTheSameBytes) {
  const Recording again = simulate_inertial(hallway());
  EXPECT_EQ(scene_bytes(again), scene_bytes(walk()));
  EXPECT_EQ(imu_bytes(again), imu_bytes(walk()));
  EXPECT_EQ(pixel_bytes(again), pixel_bytes(walk()));
  EXPECT_EQ(bias_bytes(again), bias_bytes(walk()));
}

TEST(InertialSim, AnotherRunHasOtherErrorsInTheSameScene) {
  const Recording other = simulate_inertial(hallway(), 1);
  EXPECT_EQ(scene_bytes(other), scene_bytes(walk()));
  EXPECT_NE(imu_bytes(other), imu_bytes(walk()));
  EXPECT_NE(pixel_bytes(other), pixel_bytes(walk()));
  EXPECT_NE(bias_bytes(other), bias_bytes(walk()));
}

TEST(InertialSim, AnotherSeedHasOtherLandmarksAndErrors) {
  InertialScene scene = hallway();
  scene.settings.seed = 2;
  const Recording other = simulate_inertial(scene);
  EXPECT_NE(scene_bytes(other), scene_bytes(walk()));
  EXPECT_NE(imu_bytes(other), imu_bytes(walk()));
}

TEST(InertialSim, OneSourceOfNoiseDoesNotDisturbAnother) {
  InertialScene scene = hallway();
  scene.settings.pixel_sigma = 0;
  EXPECT_EQ(imu_bytes(simulate_inertial(scene)), imu_bytes(walk()));
  scene = hallway();
  scene.settings.gyroscope_noise_density = 0;
  EXPECT_EQ(pixel_bytes(simulate_inertial(scene)), pixel_bytes(walk()));
}

TEST(RandomOfRun, RunsAreUncorrelatedWithEachOtherAndWithTheSeed) {
  constexpr int kCount = 100'000;
  const auto correlation = [](const Random& a, const Random& b) {
    double sum = 0;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      sum += a.normal(Stream::kPixelNoise, i) * b.normal(Stream::kPixelNoise, i);
    }
    return std::abs(sum) / std::sqrt(kCount);
  };
  EXPECT_LT(correlation(random_of_run(1, 0), Random{1}), kSigmas);
  EXPECT_LT(correlation(random_of_run(1, 0), random_of_run(1, 1)), kSigmas);
  EXPECT_LT(correlation(random_of_run(1, 1), random_of_run(2, 1)), kSigmas);
  EXPECT_NE(random_of_run(1, 1ULL << 32).seed, random_of_run(1, 0).seed);
}

}  // namespace
}  // namespace chasles
