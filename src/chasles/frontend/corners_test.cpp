#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend_testing.hpp>

namespace chasles::test {
namespace {

/// The shares of the pixels of a row that lie in every second field of 40 px from `first` on.
std::vector<double> field_shares(double first, int pixels) {
  constexpr int kFine = 16;
  std::vector<double> shares;
  for (int x = 0; x < pixels; ++x) {
    int odd = 0;
    for (int i = 0; i < kFine; ++i) {
      odd += static_cast<int>(std::floor((x - 0.5 + (i + 0.5) / kFine - first) / 40)) & 1;
    }
    shares.push_back(static_cast<double>(odd) / kFine);
  }
  return shares;
}

/// A chess board with corners at (x0 + 40 i, y0 + 40 j); each pixel is the mean over its area.
ImagePyramid chess_board(double x0, double y0, int width = 240, int height = 200, int levels = 1) {
  GrayImage image{.width = width, .height = height, .pixels = {}};
  const std::vector<double> across = field_shares(x0, width), down = field_shares(y0, height);
  for (const double v : down) {
    for (const double u : across) {
      image.pixels.push_back(static_cast<std::uint8_t>(40 + 160 * (u + v - 2 * u * v)));
    }
  }
  ImagePyramid pyramid;
  build_pyramid(image, Equalisation::kNone, levels, pyramid);
  return pyramid;
}

class CornersBy : public ::testing::TestWithParam<CornerMeasure> {};

TEST_P(CornersBy, OfAChessBoardAreWhereItsFieldsMeet) {
  for (const Eigen::Vector2d& origin : {Eigen::Vector2d(20.3, 17.8), Eigen::Vector2d(23.5, 21)}) {
    const ImagePyramid board = chess_board(origin.x(), origin.y());
    const auto corners =
        find_corners(board.levels[0], {.x0 = 8, .y0 = 8, .x1 = 232, .y1 = 192}, GetParam(), 3);
    std::vector<char> met(30, 0);
    for (const Corner& corner : corners) {
      const Eigen::Vector2d refined = refine_corner(board.levels[0], corner.pixel);
      const Eigen::Vector2d field = (refined - origin) / 40;
      const Eigen::Vector2d nearest(std::round(field.x()), std::round(field.y()));
      EXPECT_LT((field - nearest).norm() * 40, 0.15) << refined.transpose();
      met[static_cast<std::size_t>(nearest.y() * 6 + nearest.x())] = 1;
    }
    EXPECT_EQ(std::count(met.begin(), met.end(), 1), 30);  // 6 x 5: none on edges, none missed
  }
}

TEST_P(CornersBy, AreSortedAndInsideTheBoxAndThoseOfPartsAreThoseOfTheWhole) {
  const Camera camera = euroc_camera();
  ImagePyramid image;
  build_pyramid(room().render(camera, {}), Equalisation::kNone, 1, image);
  const PixelBox whole{.x0 = 100, .y0 = 80, .x1 = 300, .y1 = 220};
  const auto all = find_corners(image.levels[0], whole, GetParam(), 3);
  ASSERT_GT(all.size(), 20U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE(i == 0 || all[i].score <= all[i - 1].score);
    EXPECT_TRUE(all[i].pixel.x() >= 100 && all[i].pixel.x() < 300);
    EXPECT_TRUE(all[i].pixel.y() >= 80 && all[i].pixel.y() < 220);
  }
  std::size_t in_parts = 0;
  for (const int x : {100, 153, 231}) {
    const int end = x == 100 ? 153 : x == 153 ? 231 : 300;
    in_parts +=
        find_corners(image.levels[0], {.x0 = x, .y0 = 80, .x1 = end, .y1 = 220}, GetParam(), 3)
            .size();
  }
  EXPECT_EQ(in_parts, all.size());
}

TEST_P(CornersBy, HaveAtLeastTheGradientAskedFor) {
  const ImagePyramid board = chess_board(20, 20);
  const PixelBox box{.x0 = 8, .y0 = 8, .x1 = 232, .y1 = 192};
  EXPECT_EQ(find_corners(board.levels[0], box, GetParam(), 120).size(), 0U);
  EXPECT_EQ(
      find_corners(board.levels[0], {.x0 = 5, .y0 = 5, .x1 = 5, .y1 = 50}, GetParam(), 3).size(),
      0U);
}

INSTANTIATE_TEST_SUITE_P(Measures, CornersBy,
                         ::testing::Values(CornerMeasure::kHarris, CornerMeasure::kShiTomasi));

class CoverageOfARoom : public ::testing::Test {
 protected:
  CoverageOfARoom() { build_pyramid(room().render(camera, {}), Equalisation::kNone, 1, image); }

  std::vector<Eigen::Vector2d> refill(const CoverageSettings& settings, const GrayImage& mask = {},
                                      const std::vector<Eigen::Vector2d>& tracks = {}) const {
    return Coverage(settings, camera.width, camera.height).refill(image, mask, tracks);
  }

  Camera camera = euroc_camera();
  ImagePyramid image;
};

TEST_F(CoverageOfARoom, FillsTheBudgetEvenlyAndKeepsDistances) {
  for (const int budget : {1, 20, 150, 300}) {
    const auto pixels = refill({.max_tracks = budget});
    EXPECT_EQ(static_cast<int>(pixels.size()), budget);
    std::vector<int> quarter(4, 0);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      EXPECT_TRUE(in_image(camera, pixels[i], 6));  // the border minus the shift of the refinement
      ++quarter[(pixels[i].x() > 376 ? 1 : 0) + (pixels[i].y() > 240 ? 2 : 0)];
      for (std::size_t j = 0; j < i; ++j) EXPECT_GE((pixels[i] - pixels[j]).norm(), 15);
    }
    if (budget < 100) continue;
    for (const int n : quarter) EXPECT_NEAR(n, budget / 4, budget / 20);
  }
}

TEST_F(CoverageOfARoom, StopsWhereDistancesLeaveNoRoom) {
  const auto pixels = refill({.max_tracks = 5000, .min_distance = 60});
  EXPECT_GT(pixels.size(), 40U);
  EXPECT_LT(pixels.size(), 150U);
}

TEST_F(CoverageOfARoom, AddsNothingBehindTheMask) {
  GrayImage mask{.width = camera.width, .height = camera.height, .pixels = {}};
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      mask.pixels.push_back(x > 300 && x < 500 && y > 100 ? 0 : 255);
    }
  }
  const auto pixels = refill({}, mask);
  EXPECT_EQ(pixels.size(), 150U);
  for (const Eigen::Vector2d& p : pixels) EXPECT_FALSE(masked(mask, p));
  std::fill(mask.pixels.begin(), mask.pixels.end(), std::uint8_t{0});
  EXPECT_TRUE(refill({}, mask).empty());
}

TEST_F(CoverageOfARoom, FillsTheEmptyHalf) {
  auto tracks = refill({.max_tracks = 200});
  std::erase_if(tracks, [](const Eigen::Vector2d& p) { return p.x() < 376; });
  const auto added = refill({.max_tracks = 150}, {}, tracks);
  EXPECT_EQ(added.size() + tracks.size(), 150U);
  EXPECT_GT(std::count_if(added.begin(), added.end(),
                          [](const Eigen::Vector2d& p) { return p.x() < 376; }),
            static_cast<std::ptrdiff_t>(added.size() * 9 / 10));
}

TEST_F(CoverageOfARoom, WithAFullBudgetAddsNothing) {
  const auto tracks = refill({.max_tracks = 150});
  EXPECT_TRUE(refill({.max_tracks = 150}, {}, tracks).empty());
}

// Large images are searched on a coarser level; all corners of the image itself are found, also
// those between two cells, and none at its border.
TEST(Coverage, OfALargeImageHasAllCornersToATenthOfAPixel) {
  for (const auto& [width, height] : {std::pair{1000, 800}, {1224, 1024}, {2048, 1536}}) {
    ASSERT_GT(width * height, Coverage::kMostSearched);
    const Eigen::Vector2d origin(5.3, 17.8);
    const ImagePyramid board = chess_board(origin.x(), origin.y(), width, height, 4);
    Coverage coverage({.max_tracks = 5000}, width, height);
    std::vector<Eigen::Vector2d> corners;
    for (int search = 0; search < 6; ++search) {
      const auto more = coverage.refill(board, {}, corners);
      corners.insert(corners.end(), more.begin(), more.end());
    }
    for (const Eigen::Vector2d& corner : corners) {
      const Eigen::Vector2d field = (corner - origin) / 40;
      const Eigen::Vector2d nearest(std::round(field.x()), std::round(field.y()));
      EXPECT_LT((field - nearest).norm() * 40, 0.15) << corner.transpose();
      EXPECT_GT(corner.x(), 8);
    }
    const auto inside = [](double first, int pixels) {  // the first one is at the border
      return static_cast<int>((pixels - 9 - first) / 40) + 1 - (first < 8 ? 1 : 0);
    };
    EXPECT_EQ(std::ssize(corners), inside(origin.x(), width) * inside(origin.y(), height))
        << width << " x " << height;
  }
}

TEST(Coverage, OfAnEmptyWallIsEmptyAndFillsWhenTextureReturns) {
  const Camera camera = euroc_camera();
  Coverage coverage({}, camera.width, camera.height);
  ImagePyramid wall, textured;
  build_pyramid({.width = 752, .height = 480, .pixels = std::vector<std::uint8_t>(752 * 480, 90)},
                Equalisation::kNone, 1, wall);
  build_pyramid(room().render(camera, {}), Equalisation::kNone, 1, textured);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(coverage.refill(wall, {}, {}).empty());
  EXPECT_EQ(coverage.refill(textured, {}, {}).size(), 150U);
}

}  // namespace
}  // namespace chasles::test
