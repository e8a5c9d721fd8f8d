#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include <chasles/sim/texture.hpp>

namespace chasles {
namespace {

Canvas canvas(int width, int height, int (*grey)(int, int)) {
  Canvas c{.width = width, .height = height, .texel = 0.01, .pixels = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) c.pixels.push_back(static_cast<std::uint8_t>(grey(x, y)));
  }
  return c;
}

TEST(Texture, ALinearPictureIsItselfAtAllScales) {
  const Texture texture = make_texture(canvas(64, 64, [](int x, int y) { return 2 * x + y; }));
  EXPECT_EQ(texture.levels.size(), 7U);
  for (const float lod : {-3.0F, 0.0F, 0.5F, 1.0F, 1.7F, 2.0F, 2.9F}) {
    for (const float u : {16.0F, 20.3F, 40.7F}) {
      for (const float v : {15.5F, 31.0F, 33.3F}) {
        // The middle of texel 0 is at 1/2; each level rounds to whole shades.
        EXPECT_NEAR(sample(texture, u, v, lod), 2 * (u - 0.5F) + v - 0.5F,
                    lod <= 0 ? 3.0 / 256 : 0.6)
            << lod << " " << u << " " << v;
      }
    }
  }
}

TEST(Texture, FarAwayItIsItsMean) {
  const auto checker = [](int x, int y) { return (x + y) % 2 == 0 ? 200 : 100; };
  const Texture texture = make_texture(canvas(32, 32, checker));
  for (const float lod : {1.0F, 2.5F, 5.0F, 30.0F}) {
    EXPECT_NEAR(sample(texture, 13.2F, 7.9F, lod), 150, 1.01) << lod;
  }
}

TEST(Texture, ItsEdgesAreRepeatedAndOddSizesKeepTheirPlace) {
  const Texture texture = make_texture(canvas(5, 3, [](int x, int) { return 40 * x; }));
  EXPECT_FLOAT_EQ(sample(texture, 0, 0, 0), 0);
  EXPECT_FLOAT_EQ(sample(texture, 5, 3, 0), 160);
  EXPECT_EQ(texture.levels[1].width, 3);
  // The middle of the second pair is at 3.
  EXPECT_FLOAT_EQ(sample(texture, 3, 1, 1), 100);
  EXPECT_EQ(texture.levels.back().width, 1);
  for (const float lod : {1.5F, 2.0F, 3.0F, 9.0F}) {
    EXPECT_TRUE(std::isfinite(sample(texture, 5, 3, lod)));
  }
}

}  // namespace
}  // namespace chasles
