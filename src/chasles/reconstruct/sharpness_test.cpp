#include <cmath>

#include <gtest/gtest.h>

#include <chasles/reconstruct/sharpness.hpp>

namespace chasles {
namespace {

// A wave of this length [px] in x.
GrayImage wave(double length) {
  GrayImage image{.width = 64, .height = 48, .pixels = {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double grey = 128 + 100 * std::sin(2 * std::numbers::pi * x / length);
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(grey)));
    }
  }
  return image;
}

TEST(Sharpness, IsTheVarianceOfTheLaplacianAtHalfResolution) {
  // Of columns of two pixels with 0 or 80, the Laplacian is +-160.
  GrayImage stripes{.width = 16, .height = 8, .pixels = {}};
  for (int i = 0; i < 16 * 8; ++i) stripes.pixels.push_back(i % 16 / 2 % 2 == 0 ? 0 : 80);
  EXPECT_EQ(sharpness(stripes), 160 * 160);
  // A wave of w times the frequency has a Laplacian of (2 - 2 cos w) times its amplitude.
  EXPECT_NEAR(sharpness(wave(16)), std::pow((2 - 2 * std::cos(std::numbers::pi / 4)) * 98, 2) / 2,
              150);
  EXPECT_LT(sharpness(wave(32)), sharpness(wave(16)) / 8);
}

TEST(Sharpness, ABlankOrATinyImageHasNone) {
  EXPECT_EQ(sharpness({.width = 9, .height = 7, .pixels = std::vector<std::uint8_t>(63, 50)}), 0);
  EXPECT_EQ(sharpness({.width = 2, .height = 2, .pixels = {1, 2, 3, 4}}), 0);
}

TEST(Sharpness, IsComparedWithTheNeighboursAlone) {
  // A step of the scene, and one blurred frame on either side of it.
  std::vector<double> values(40, 10);
  for (std::size_t i = 20; i < 40; ++i) values[i] = 1000;
  values[10] = 2;
  values[30] = 200;
  const std::vector<double> relative = relative_sharpness(values);
  EXPECT_DOUBLE_EQ(relative[10], 0.2);
  EXPECT_DOUBLE_EQ(relative[30], 0.2);
  EXPECT_DOUBLE_EQ(relative[5], 1);
  EXPECT_DOUBLE_EQ(relative[35], 1);
  EXPECT_EQ(relative_sharpness({0, 0}), (std::vector<double>{1, 1}));
  EXPECT_EQ(relative_sharpness({3}), std::vector<double>{1});
}

}  // namespace
}  // namespace chasles
