#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <chasles/initialise/initialiser_motion_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/sim/inertial_sim.hpp>

// The initialisation with real IMUs: simulated pixels on real flights, and real pixels.

namespace chasles {
namespace {

using namespace test;

std::filesystem::path euroc() {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path data =
      given ? given : std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data";
  return data / "euroc";
}

// A flight's motion and its real IMU samples, with simulated pixels.
InertialScene flight(const std::string& name, int cameras, Recording& samples) {
  samples = read_recording(euroc() / "imu_gt" / (name + "_imu.csv.gz"));
  InertialScene scene = inertial_scene("trajectory");
  scene.path = samples.truth;
  scene.imu = samples.imu;
  InertialSettings& s = scene.settings;
  s.imu_convention = samples.imu_convention;
  // The tables state none: values of the recordings' sensor.yaml.
  const ImuNoise noise = samples.imu_noise.value_or(
      ImuNoise{.accelerometer_noise_density = 2e-3, .gyroscope_noise_density = 1.6968e-4});
  s.accelerometer_noise_density = noise.accelerometer_noise_density;
  s.gyroscope_noise_density = noise.gyroscope_noise_density;
  s.frame_rate = 20;
  s.cameras = cameras;
  s.baseline = 0.11;
  s.min_range = 1;
  return scene;
}

TEST(Initialiser, StartsInTheAirWithTheImuOfTheFlights) {
  if (!std::filesystem::exists(euroc() / "imu_gt")) GTEST_SKIP() << "skipped: no recordings";
  for (const int cameras : {1, 2}) {
    Study all, known;
    for (const char* name :
         {"V1_01_easy", "V1_02_medium", "V2_01_easy", "MH_01_easy", "MH_03_medium"}) {
      Recording samples;
      const InertialScene scene = flight(name, cameras, samples);
      Recording recording = simulate_inertial(scene, 0);
      recording.true_motion = samples.true_motion;
      const Spline motion = inertial_motion(scene);
      Study one;
      const double last = to_seconds(recording.frames.back().time - recording.frames.front().time);
      for (int i = 0; i < 5; ++i) {
        const test::StartOutcome outcome = initialise(recording, 2 + (last - 10) * i / 5, 8, {});
        one.add(outcome, recording, motion);
        all.add(outcome, recording, motion);
        if (!samples.true_motion.empty()) known.add(outcome, recording, motion);
      }
      one.print(std::string(name) + (cameras == 1 ? " mono" : " stereo"));
    }
    all.print(cameras == 1 ? "all mono" : "all stereo");
    EXPECT_GE(all.started, 24);
    EXPECT_LT(median(all.velocity), cameras == 1 ? 0.08 : 0.05);
    // The accelerometer bias of 0.15 m/s^2 appears as a tilt of 0.9 degrees.
    EXPECT_LT(median(all.tilt), 1.1 / kDegrees);
    EXPECT_LT(median(known.gyroscope), 0.005);
  }
}

TEST(Initialiser, StartsOnRealPixels) {
  if (!std::filesystem::exists(euroc() / "imu_april")) GTEST_SKIP() << "skipped: no recordings";
  Recording recording = read_recording(euroc() / "imu_april");
  recording.single_pixel_sigma = 0.5;
  const Spline motion = fit_spline(recording.truth, 0.1);
  Study stereo;
  const double last = to_seconds(recording.frames.back().time - recording.frames.front().time);
  for (int i = 0; i < 10; ++i) {
    stereo.add(initialise(recording, 0.5 + (last - 6) * i / 10, 5, {}), recording, motion);
  }
  stereo.print("AprilGrid stereo");
  EXPECT_GE(stereo.started, 9);
  EXPECT_LT(median(stereo.velocity), 0.05);
  EXPECT_LT(median(stereo.tilt), 1.3 / kDegrees);
}

}  // namespace
}  // namespace chasles
