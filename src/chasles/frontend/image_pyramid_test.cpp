#include <numeric>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <chasles/base/error.hpp>
#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles::test {
namespace {

GrayImage random_image(int width, int height) {
  Random random(3);
  GrayImage image{.width = width, .height = height, .pixels = {}};
  for (int i = 0; i < width * height; ++i) {
    image.pixels.push_back(static_cast<std::uint8_t>(random.next() & 255));
  }
  return image;
}

ImagePyramid pyramid_of(const GrayImage& image, int levels,
                        Equalisation equalisation = Equalisation::kNone) {
  ImagePyramid pyramid;
  build_pyramid(image, equalisation, levels, pyramid);
  return pyramid;
}

TEST(ImagePyramid, LevelZeroIsTheImageMirroredBeyondItsEdges) {
  const GrayImage image = random_image(61, 47);
  const ImagePyramid pyramid = pyramid_of(image, 1);
  const PyramidLevel& level = pyramid.levels.at(0);
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * (n - 1) - i : i; };
  for (int y = -PyramidLevel::kPad; y < 47 + PyramidLevel::kPad; ++y) {
    for (int x = -PyramidLevel::kPad; x < 61 + PyramidLevel::kPad; ++x) {
      const int i = mirrored(y, 47) * 61 + mirrored(x, 61);
      ASSERT_EQ(*level.at(x, y), image.pixels[static_cast<std::size_t>(i)]) << x << ' ' << y;
    }
  }
}

TEST(ImagePyramid, PixelsOfALevelLieAtHalfTheirCoordinates) {
  GrayImage image{.width = 160, .height = 120, .pixels = {}};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) image.pixels.push_back(static_cast<std::uint8_t>(x + y / 2));
  }
  const ImagePyramid pyramid = pyramid_of(image, 3);
  ASSERT_EQ(pyramid.levels.size(), 3U);
  for (int l = 0; l < 3; ++l) {
    const PyramidLevel& level = pyramid.levels[static_cast<std::size_t>(l)];
    EXPECT_EQ(level.width, 160 >> l);
    EXPECT_EQ(level.height, 120 >> l);
    for (int y = 4; y < level.height - 4; ++y) {
      for (int x = 4; x < level.width - 4; ++x) {
        ASSERT_NEAR(*level.at(x, y), (x << l) + (y << l) / 2.0, 1.01);
      }
    }
  }
}

// OpenCV's image, without padding.
cv::Mat mat_of(const GrayImage& image) {
  return cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()))
      .clone();
}

void expect_level(const PyramidLevel& level, const cv::Mat& expected) {
  ASSERT_EQ(level.width, expected.cols);
  ASSERT_EQ(level.height, expected.rows);
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x) {
      ASSERT_EQ(*level.at(x, y), expected.at<std::uint8_t>(y, x)) << x << ' ' << y;
    }
  }
}

TEST(ImagePyramid, HalvesAndEqualisesToThePixelsOfOpenCv) {
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{752, 480}, {161, 104}, {104, 161}, {160, 121}, {61, 47}}) {
    SCOPED_TRACE(width);
    const GrayImage image = random_image(width, height);
    cv::Mat expected = mat_of(image);
    const ImagePyramid pyramid = pyramid_of(image, 4);
    for (const PyramidLevel& level : pyramid.levels) {
      expect_level(level, expected);
      cv::pyrDown(expected, expected);
    }
    // Dark ones, so that the tables are not the identity.
    GrayImage dark = image;
    for (std::size_t i = 0; i < dark.pixels.size(); ++i) {
      dark.pixels[i] = static_cast<std::uint8_t>(20 + dark.pixels[i] / (3 + i % 7));
    }
    cv::equalizeHist(mat_of(dark), expected);
    expect_level(pyramid_of(dark, 1, Equalisation::kHistogram).levels[0], expected);
    cv::createCLAHE(3.0, cv::Size(8, 8))->apply(mat_of(dark), expected);
    expect_level(pyramid_of(dark, 1, Equalisation::kClahe).levels[0], expected);
  }
  const GrayImage flat{.width = 40, .height = 40, .pixels = std::vector<std::uint8_t>(1600, 77)};
  expect_level(pyramid_of(flat, 1, Equalisation::kHistogram).levels[0], mat_of(flat));
}

TEST(ImagePyramid, HasNoLevelSmallerThanItsPadding) {
  EXPECT_EQ(pyramid_of(random_image(752, 480), 6).levels.size(), 5U);
  EXPECT_EQ(pyramid_of(random_image(25, 25), 6).levels.size(), 1U);
}

TEST(ImagePyramid, ReusedMemoryHoldsTheNewImageOnly) {
  ImagePyramid reused = pyramid_of(random_image(200, 100), 3);
  const GrayImage smaller = random_image(90, 80);
  build_pyramid(smaller, Equalisation::kNone, 2, reused);
  const ImagePyramid fresh = pyramid_of(smaller, 2);
  ASSERT_EQ(reused.levels.size(), fresh.levels.size());
  for (std::size_t l = 0; l < fresh.levels.size(); ++l) {
    EXPECT_EQ(reused.levels[l].padded, fresh.levels[l].padded);
  }
}

TEST(ImagePyramid, EqualisationSpreadsTheGreyLevels) {
  GrayImage dull = random_image(200, 160);
  for (std::uint8_t& v : dull.pixels) v = static_cast<std::uint8_t>(100 + v / 16);
  const auto spread = [&](Equalisation equalisation) {
    const ImagePyramid pyramid = pyramid_of(dull, 1, equalisation);
    double sum = 0, squares = 0;
    for (int y = 0; y < 160; ++y) {
      for (int x = 0; x < 200; ++x) {
        const double v = *pyramid.levels[0].at(x, y);
        sum += v;
        squares += v * v;
      }
    }
    const double n = 200 * 160;
    return std::sqrt(squares / n - sum * sum / n / n);
  };
  EXPECT_LT(spread(Equalisation::kNone), 6);
  EXPECT_GT(spread(Equalisation::kHistogram), 60);
  EXPECT_GT(spread(Equalisation::kClahe), 9);
}

TEST(ImagePyramid, SeparatesBlackAndSaturatedImagesFromUsableOnes) {
  GrayImage image = random_image(100, 100);
  EXPECT_EQ(exposure(pyramid_of(image, 3)), Exposure::kUsable);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{3});
  EXPECT_EQ(exposure(pyramid_of(image, 3)), Exposure::kBlack);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{255});
  EXPECT_EQ(exposure(pyramid_of(image, 3)), Exposure::kSaturated);
  std::fill(image.pixels.begin(), image.pixels.begin() + 1000, std::uint8_t{90});
  EXPECT_EQ(exposure(pyramid_of(image, 3)), Exposure::kUsable);
}

TEST(ImagePyramid, RejectsAnImageWhosePixelsAreNotWidthTimesHeight) {
  GrayImage image = random_image(60, 50);
  image.pixels.pop_back();
  EXPECT_THROW(pyramid_of(image, 2), InputError);
  EXPECT_THROW(pyramid_of(random_image(60, 24), 2), InputError);
  EXPECT_THROW(pyramid_of({}, 2), InputError);
}

}  // namespace
}  // namespace chasles::test
