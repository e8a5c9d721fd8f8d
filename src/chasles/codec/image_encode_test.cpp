#include <gtest/gtest.h>

#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/image_encode.hpp>

namespace chasles {
namespace {

// A grey ramp that rises by one per column.
GrayImage ramp(int width, int height) {
  GrayImage image{.width = width, .height = height, .pixels = {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image.pixels.push_back(static_cast<std::uint8_t>(u));
  }
  return image;
}

TEST(JpegBytes, ShowWhatTheImageShows) {
  const GrayImage image = ramp(64, 32);
  const GrayImage again = decode_image(jpeg_bytes(image, 64), {.width = 64, .height = 32}, "");
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    ASSERT_NEAR(again.pixels[i], image.pixels[i], 4) << i;
  }
  EXPECT_EQ(jpeg_bytes(image, 64), jpeg_bytes(image, 64));
}

TEST(JpegBytes, AWideOneIsMadeSmallerByAveraging) {
  const GrayImage again =
      decode_image(jpeg_bytes(ramp(200, 60), 50), {.width = 50, .height = 15}, "");
  for (int u = 2; u < 48; ++u) {  // four columns each
    EXPECT_NEAR(again.pixels[static_cast<std::size_t>(5 * 50 + u)], 4 * u + 1.5, 3) << u;
  }
}

TEST(JpegBytes, AWidthThatDoesNotDivideTheImageIsAveragedByShares) {
  const GrayImage again =
      decode_image(jpeg_bytes(ramp(250, 100), 100), {.width = 100, .height = 40}, "");
  for (int u = 2; u < 98; ++u) {  // two columns and a half each
    EXPECT_NEAR(again.pixels[static_cast<std::size_t>(5 * 100 + u)], 2.5 * u + 0.75, 3) << u;
  }
}

TEST(JpegBytes, ASmallOneStaysAsItIsAndNoneIsNothing) {
  EXPECT_EQ(stated_size(jpeg_bytes(ramp(20, 10), 480), ""), (ImageSize{20, 10}));
  EXPECT_EQ(stated_size(jpeg_bytes(ramp(700, 1), 70), ""), (ImageSize{70, 1}));
  EXPECT_TRUE(jpeg_bytes({}, 480).empty());
}

}  // namespace
}  // namespace chasles
