#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <chasles/numeric/random.hpp>
#include <chasles/sim/render_sensor.hpp>

namespace chasles {
namespace {

constexpr int kQuantileBits = 12;

double normal_quantile(double probability) {
  double low = -10, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (std::erfc(-middle / std::numbers::sqrt2) / 2 < probability ? low : high) = middle;
  }
  return low;
}

// The midpoints of intervals of equal probability, scaled to variance 1.
std::vector<float> normal_quantiles() {
  constexpr int kCount = 1 << kQuantileBits;
  std::vector<double> exact;
  double square = 0;
  for (int i = 0; i < kCount; ++i) {
    exact.push_back(normal_quantile((i + 0.5) / kCount));
    square += exact.back() * exact.back();
  }
  const double scale = std::sqrt(kCount / square);
  std::vector<float> result;
  for (const double q : exact) result.push_back(static_cast<float>(scale * q));
  return result;
}

// The square of half the diagonal.
float squared_radius(int u, int v, int width, int height) {
  const float x = 2 * static_cast<float>(u) - static_cast<float>(width - 1);
  const float y = 2 * static_cast<float>(v) - static_cast<float>(height - 1);
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  return (x * x + y * y) / (w * w + h * h);
}

}  // namespace

RenderSensor::RenderSensor(const InertialSettings& settings, std::uint64_t run)
    : settings_(settings),
      key_(random_of_run(settings.seed, run).seed),
      normals_(normal_quantiles()),
      phases_{} {
  const Random random{key_};
  for (std::uint32_t i = 0; i < 2; ++i) {
    phases_[i] = 2 * std::numbers::pi * random.uniform(Stream::kExposure, 0, i);
  }
}

double RenderSensor::exposure_at(double time) const {
  constexpr double kPeriods[] = {11, 27};  // [s]
  double wander = 0;
  for (int i = 0; i < 2; ++i) {
    wander += std::sin(2 * std::numbers::pi * time / kPeriods[i] + phases_[i]) / 2;
  }
  return settings_.exposure * std::exp2(settings_.exposure_drift * wander);
}

GrayImage RenderSensor::expose(const std::vector<float>& light, int width, int height, double time,
                               std::uint32_t frame, std::uint32_t camera) const {
  const auto gain = static_cast<float>(exposure_at(time));
  const auto vignetting = static_cast<float>(settings_.vignetting);
  const auto photon = static_cast<float>(settings_.photon_noise);
  const auto readout = static_cast<float>(settings_.readout_noise * settings_.readout_noise);
  const std::array<std::uint32_t, 2> key{static_cast<std::uint32_t>(key_),
                                         static_cast<std::uint32_t>(key_ >> 32)};
  GrayImage image{.width = width, .height = height, .pixels = {}};
  image.pixels.resize(light.size());
  std::array<std::uint32_t, 4> bits{};
  for (std::size_t i = 0; i < light.size(); ++i) {
    // Eight numbers of 16 bits from each block of 128.
    if (i % 8 == 0) {
      bits = philox({static_cast<std::uint32_t>(i / 8), frame,
                     static_cast<std::uint32_t>(Stream::kImageNoise), camera},
                    key);
    }
    const std::uint32_t part = bits[i % 8 / 2] >> (i % 2 * 16) & 0xFFFFU;
    float mean = gain * light[i];
    if (vignetting > 0) {
      const auto u = static_cast<int>(i % static_cast<std::size_t>(width));
      const auto v = static_cast<int>(i / static_cast<std::size_t>(width));
      mean *= 1 - vignetting * squared_radius(u, v, width, height);
    }
    const float noise = std::sqrt(readout + photon * mean) * normals_[part >> (16 - kQuantileBits)];
    image.pixels[i] = static_cast<std::uint8_t>(std::clamp(mean + noise + 0.5F, 0.0F, 255.0F));
  }
  return image;
}

}  // namespace chasles
