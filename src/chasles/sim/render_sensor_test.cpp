#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <chasles/sim/render_sensor.hpp>

namespace chasles {
namespace {

constexpr int kWidth = 320, kHeight = 240;

InertialSettings settings(double readout, double photon) {
  InertialSettings s;
  s.readout_noise = readout;
  s.photon_noise = photon;
  return s;
}

std::vector<float> even(float shade) {
  return std::vector<float>(std::size_t{kWidth} * kHeight, shade);
}

struct Moments {
  double mean = 0, variance = 0, neighbours = 0;  // correlation of a pixel with the next one
};

Moments moments(const GrayImage& image) {
  Moments m;
  const auto n = static_cast<double>(image.pixels.size());
  for (const std::uint8_t p : image.pixels) m.mean += p / n;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double d = image.pixels[i] - m.mean;
    m.variance += d * d / n;
    if (i > 0) m.neighbours += d * (image.pixels[i - 1] - m.mean) / n;
  }
  m.neighbours /= m.variance;
  return m;
}

TEST(RenderSensor, NoiseHasTheVarianceOfReadoutAndPhotons) {
  for (const float shade : {40.0F, 120.0F, 200.0F}) {
    const RenderSensor sensor(settings(2, 0.05), 0);
    const Moments m = moments(sensor.expose(even(shade), kWidth, kHeight, 0, 0, 0));
    const double variance = 4 + 0.05 * static_cast<double>(shade) + 1.0 / 12;
    // 76800 pixels: five standard deviations of the mean and of the variance.
    EXPECT_NEAR(m.mean, shade, 5 * std::sqrt(variance / 76800));
    EXPECT_NEAR(m.variance / variance, 1, 5 * std::sqrt(2.0 / 76800));
    EXPECT_LT(std::abs(m.neighbours), 5 / std::sqrt(76800.0));
  }
}

TEST(RenderSensor, WithoutNoiseAShadeIsItself) {
  const GrayImage image =
      RenderSensor(settings(0, 0), 0).expose(even(99.8F), kWidth, kHeight, 3, 1, 0);
  EXPECT_TRUE(std::ranges::all_of(image.pixels, [](int p) { return p == 100; }));
}

TEST(RenderSensor, NoiseBelongsToSeedRunFrameAndCamera) {
  InertialSettings other_seed = settings(2, 0);
  other_seed.seed = 7;
  const auto image = [](const InertialSettings& s, std::uint64_t run, std::uint32_t frame,
                        std::uint32_t camera) {
    return RenderSensor(s, run).expose(even(100), kWidth, kHeight, 0, frame, camera).pixels;
  };
  const auto first = image(settings(2, 0), 0, 0, 0);
  EXPECT_EQ(first, image(settings(2, 0), 0, 0, 0));
  EXPECT_NE(first, image(other_seed, 0, 0, 0));
  EXPECT_NE(first, image(settings(2, 0), 1, 0, 0));
  EXPECT_NE(first, image(settings(2, 0), 0, 1, 0));
  EXPECT_NE(first, image(settings(2, 0), 0, 0, 1));
}

TEST(RenderSensor, BrightnessEndsAtBlackAndWhite) {
  const RenderSensor sensor(settings(3, 0), 0);
  for (const std::uint8_t p : sensor.expose(even(400), kWidth, kHeight, 0, 0, 0).pixels) {
    ASSERT_EQ(p, 255);
  }
  EXPECT_LT(moments(sensor.expose(even(0), kWidth, kHeight, 0, 0, 0)).mean, 2);
}

TEST(RenderSensor, ExposureWandersWithinItsStops) {
  InertialSettings s = settings(0, 0);
  s.exposure = 0.9;
  s.exposure_drift = 0.5;
  const RenderSensor sensor(s, 2);
  double least = 10, most = 0, last = sensor.exposure_at(0);
  for (double t = 0; t < 300; t += 0.05) {
    const double now = sensor.exposure_at(t);
    EXPECT_LT(std::abs(now / last - 1), 0.01) << "a jump";
    least = std::min(least, now);
    most = std::max(most, now);
    last = now;
  }
  EXPECT_GT(least, 0.9 * std::exp2(-0.5));
  EXPECT_LT(most, 0.9 * std::exp2(0.5));
  EXPECT_GT(std::log2(most / least), 0.8);
  s.exposure_drift = 0;
  EXPECT_DOUBLE_EQ(RenderSensor(s, 2).exposure_at(17), 0.9);
}

TEST(RenderSensor, VignettingDarkensTheCorners) {
  InertialSettings s = settings(0, 0);
  s.vignetting = 0.4;
  const auto pixels = RenderSensor(s, 0).expose(even(200), kWidth, kHeight, 0, 0, 0).pixels;
  EXPECT_EQ(pixels[std::size_t{kHeight} / 2 * kWidth + kWidth / 2], 200);
  for (const std::size_t corner : {std::size_t{0}, std::size_t{kWidth - 1}, pixels.size() - 1}) {
    EXPECT_NEAR(pixels[corner], 120, 2);
  }
}

}  // namespace
}  // namespace chasles
