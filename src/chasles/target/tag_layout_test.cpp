#include <gtest/gtest.h>

#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_testing.hpp>

namespace chasles {
namespace {

const std::vector<Target> kBoards = {
    {.kind = TargetKind::april_grid, .columns = 3, .rows = 2, .tag_size = 0.1, .tag_spacing = 0.3},
    {.kind = TargetKind::checkerboard,
     .columns = 5,
     .rows = 4,
     .column_spacing = 0.04,
     .row_spacing = 0.05},
    {.kind = TargetKind::charuco,
     .columns = 4,
     .rows = 6,
     .tag_size = 0.03,
     .column_spacing = 0.04,
     .row_spacing = 0.04,
     .dictionary = "DICT_4X4_50",
     .legacy_pattern = true}};

TEST(TagLayout, RectanglesAreWhatTheRendererPrints) {
  const Random random{5};
  for (const Target& target : kBoards) {
    const test::TargetRenderer renderer(target, Camera{});
    const auto rectangles = black_rectangles(target);
    const PrintedRectangle outline = board_outline(target);
    int black = 0;
    for (std::uint64_t k = 0; k < 20000; ++k) {
      const Eigen::Vector2d part(random.uniform(Stream::kLandmark, k, 0),
                                 random.uniform(Stream::kLandmark, k, 1));
      const Eigen::Vector2d p =
          outline.lower_left + part.cwiseProduct(outline.upper_right - outline.lower_left);
      int covered = 0;
      for (const auto& r : rectangles) {
        covered +=
            (p.array() >= r.lower_left.array()).all() && (p.array() < r.upper_right.array()).all();
      }
      ASSERT_EQ(covered, renderer.is_black(p) ? 1 : 0) << p.transpose();
      black += covered;
    }
    EXPECT_GT(black, 5000);
    EXPECT_LT(black, 15000);
  }
}

TEST(TagLayout, CornersOfTheGridAreThoseOfTheTarget) {
  for (const Target& target : kBoards) {
    const auto corners = target.corners();
    const CornerGrid grid = corner_grid(target);
    ASSERT_EQ(static_cast<int>(corners.size()), grid.columns * grid.rows);
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column + 1 < grid.columns; ++column) {
        const auto at = [&](int c) {
          return corners[static_cast<std::size_t>(corner_id(target, {c, row}))];
        };
        EXPECT_GT(at(column + 1).x(), at(column).x());
        EXPECT_EQ(at(column + 1).y(), at(column).y());
      }
    }
  }
}

// A corner is where four squares meet, dark in the stated directions.
TEST(TagLayout, CornersAreSaddles) {
  for (const Target& target : kBoards) {
    const test::TargetRenderer renderer(target, Camera{});
    const CornerGrid grid = corner_grid(target);
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const Eigen::Vector2d p =
            target.corners()[static_cast<std::size_t>(corner_id(target, {column, row}))].head<2>();
        const bool rising = is_dark_to_upper_right(target, {column, row});
        for (const auto& [dx, dy] : {std::pair(1, 1), {1, -1}, {-1, 1}, {-1, -1}}) {
          EXPECT_EQ(renderer.is_black(p + 1e-3 * Eigen::Vector2d(dx, dy)), rising == (dx == dy));
        }
      }
    }
  }
}

}  // namespace
}  // namespace chasles
