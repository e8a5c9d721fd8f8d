#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <chasles/initialise/initialiser_testing.hpp>
#include <chasles/initialise/standstill.hpp>

namespace chasles {
namespace {

using namespace test;

constexpr int kImuRate = 200, kImageRate = 20, kTracks = 40;
using ForceOf = std::function<Eigen::Vector3d(double t)>;
using ShiftOf = std::function<double(double t)>;

// The data of an IMU and one camera: a force, and tracks displaced by `shift` pixels; no tracks
// where it is NaN.
struct Scene {
  ForceOf force = [](double) { return Eigen::Vector3d(0.3, 0.1, 9.8); };
  ShiftOf shift = [](double) { return 0.0; };
};

// Begin and end of the detected standstill.
struct DetectedStandstill {
  double begin = -1, end = -1;
  int frames = 0;
};

DetectedStandstill watch(const Scene& scene, double seconds) {
  Standstill standstill(kNoise, 1, 1);
  Normal normal(7);
  DetectedStandstill observed;
  const double root = std::sqrt(kImuRate);
  for (int i = 0; i < seconds * kImuRate; ++i) {
    const double t = i / static_cast<double>(kImuRate);
    standstill.add({.time = from_seconds(t),
                    .specific_force_imu =
                        scene.force(t) + normal.vector(kNoise.accelerometer_noise_density * root),
                    .angular_rate_imu = normal.vector(kNoise.gyroscope_noise_density * root)});
    if (i % (kImuRate / kImageRate) != 0) continue;
    FeatureFrame frame{.time = from_seconds(t)};
    for (int k = 0; k < kTracks && std::isfinite(scene.shift(t)); ++k) {
      const Eigen::Vector2d noise(normal(), normal());
      frame.pixels.push_back(
          {.landmark = k,
           .pixel = Eigen::Vector2d(100 + 10 * k + scene.shift(t), 50 + 7 * k) + noise});
    }
    if (!standstill.detected(frame)) continue;
    if (observed.frames++ == 0) observed.begin = t;
    observed.end = t;
  }
  return observed;
}

constexpr double kBlind = std::numeric_limits<double>::quiet_NaN();

TEST(Standstill, IsSaidAfterHalfASecondAndHolds) {
  const DetectedStandstill observed = watch({}, 5);
  EXPECT_NEAR(observed.begin, 0.5, 0.06);
  EXPECT_NEAR(observed.end, 5, 0.06);
  EXPECT_GE(observed.frames, 88);
}

TEST(Standstill, TracksThatMoveSteadilyDenyIt) {
  // 20 px a second: 5 cm/s at 1 m with a focal length of 400 px. The IMU measures no acceleration.
  EXPECT_EQ(watch({.shift = [](double t) { return 20 * t; }}, 5).frames, 0);
}

TEST(Standstill, SamplesThatSwayDenyItWhateverTheTracksSay) {
  const Scene scene{
      .force = [](double t) { return Eigen::Vector3d(3 * std::sin(40 * t), 0, 9.8); }};
  EXPECT_EQ(watch(scene, 5).frames, 0);
}

TEST(Standstill, NeverBeginsInTheDark) {
  EXPECT_EQ(watch({.shift = [](double) { return kBlind; }}, 5).frames, 0);
}

TEST(Standstill, GoesOnInTheDarkUntilSomethingPushes) {
  Scene scene{.shift = [](double t) { return t < 2 ? 0 : kBlind; }};
  EXPECT_NEAR(watch(scene, 6).end, 6, 0.06);
  // A gentle start, far below the scatter of the samples (0.14 m/s^2), after 4 s.
  scene.force = [](double t) { return Eigen::Vector3d(0.3 + (t < 4 ? 0 : 0.12), 0.1, 9.8); };
  const double end = watch(scene, 8).end;
  EXPECT_GE(end, 3.9);
  EXPECT_LT(end, 4.5);
}

TEST(Standstill, NeedsSamples) {
  Standstill standstill(kNoise, 1, 1);
  FeatureFrame frame;
  for (int k = 0; k < kTracks; ++k) frame.pixels.push_back({.landmark = k});
  for (int i = 0; i < 50; ++i) {
    frame.time = from_seconds(0.05 * i);
    standstill.add({.time = frame.time,
                    .specific_force_imu = Eigen::Vector3d::Constant(kBlind),
                    .angular_rate_imu = Eigen::Vector3d::Zero()});
    EXPECT_FALSE(standstill.detected(frame));
  }
}

}  // namespace
}  // namespace chasles
