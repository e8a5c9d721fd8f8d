#include <gtest/gtest.h>

#include <chasles/calibrate/noise/motion_noise.hpp>
#include <chasles/calibrate/noise/noise_testing.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles::test {
namespace {

double true_density(std::size_t signal) {
  return signal < 3 ? kSensorNoise.accelerometer_noise_density
                    : kSensorNoise.gyroscope_noise_density;
}

TEST(MotionNoise, TheDensityAndItsSigmaAreThoseOfTheSensorDuringAMotion) {
  constexpr std::uint64_t kRuns = 20;
  double nees = 0;
  std::size_t inside = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    Recording recording = standstill_recording(40, 200, kSensorNoise, run);
    add_motion(recording, 0, 40);
    const auto band = motion_noise(even_samples(recording.imu, {}).spans);
    ASSERT_TRUE(band);
    EXPECT_NEAR(band->lowest, 40, 1e-6);
    EXPECT_NEAR(band->highest, 60, 1e-6);
    for (std::size_t i = 0; i < kImuSignals; ++i) {
      const MotionNoise& found = band->signals[i];
      const double error = std::log(found.density / true_density(i)) / found.relative_sigma;
      nees += error * error;
      inside += std::abs(error) < 3 ? 1 : 0;
      EXPECT_NEAR(found.quietest / true_density(i), 1, 0.2);
    }
  }
  constexpr std::size_t kEstimates = kRuns * kImuSignals;
  EXPECT_GE(static_cast<double>(inside), 0.98 * kEstimates);
  // A sigma of the scatter of 40 windows is itself known to 11 %.
  EXPECT_TRUE(chi2_band(1, kEstimates, 0.999).contains(nees / kEstimates)) << nees / kEstimates;
}

// By the project's simulator, whose walker has steps.
TEST(MotionNoise, ASimulatedWalkHasTheNoiseOfItsSensor) {
  InertialScene scene = inertial_scene("walk");
  scene.settings.walk_duration = 40;
  scene.settings.imu_rate = 200;
  const Recording recording = simulate_inertial(scene, 1);
  const auto band = motion_noise(even_samples(recording.imu, {}).spans);
  ASSERT_TRUE(band);
  ASSERT_TRUE(recording.imu_noise);
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    const double density = i < 3 ? recording.imu_noise->accelerometer_noise_density
                                 : recording.imu_noise->gyroscope_noise_density;
    EXPECT_NEAR(band->signals[i].density / density, 1, 0.1) << i;
  }
}

TEST(MotionNoise, AVibrationIsInTheDensityAndNotInTheQuietestTenth) {
  Recording recording = standstill_recording(60, 200, kSensorNoise, 7);
  for (std::size_t i = 2400; i < recording.imu.size(); ++i) {           // from 12 s on
    recording.imu[i].angular_rate_imu.y() += i % 4 < 2 ? 0.02 : -0.02;  // 50 Hz
  }
  const auto band = motion_noise(even_samples(recording.imu, {}).spans);
  ASSERT_TRUE(band);
  EXPECT_GT(band->signals[4].density, 10 * true_density(4));
  // A fifth of the windows is quiet: their median is taken for the tenth of a larger number.
  EXPECT_GT(band->signals[4].quietest / true_density(4), 0.9);
  EXPECT_LT(band->signals[4].quietest / true_density(4), 1.4);
}

TEST(MotionNoise, FourSecondsAreTooFew) {
  const Recording recording = standstill_recording(4.5, 200, kSensorNoise, 8);
  EXPECT_FALSE(motion_noise(even_samples(recording.imu, {}).spans));
}

}  // namespace
}  // namespace chasles::test
