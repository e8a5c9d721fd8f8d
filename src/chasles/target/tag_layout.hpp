#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/target.hpp>

namespace chasles {

/// A tag or marker as a target has it, upright.
struct PrintedTag {
  Eigen::Vector2d lower_left;  ///< corner of its black border, in the frame of the target [m]
  Eigen::Vector2i grid;        ///< that corner, or its white square's, in the grid of corners
  std::uint64_t code = 0;      ///< bits row by row from the upper left, the first highest; 1 white
};

/// The number of tags; 0 for a checkerboard.
std::size_t count_tags(const Target& target);

/// The tags in the order of their ids. Throws UsageError for an unknown dictionary.
std::vector<PrintedTag> printed_tags(const Target& target);

/// The corners of a target as a grid: columns from the left, rows from below, without gaps.
struct CornerGrid {
  int columns = 0, rows = 0;
};
CornerGrid corner_grid(const Target& target);

bool is_in(const CornerGrid& grid, const Eigen::Vector2i& at);

/// The id of a corner of the grid.
int corner_id(const Target& target, const Eigen::Vector2i& at);

/// Whether it is black to the upper right and lower left of a corner of the grid, and white at the
/// other sides; otherwise the other way round.
bool is_dark_to_upper_right(const Target& target, const Eigen::Vector2i& at);

/// Cells of the border of a tag, and of all of it, along a side.
struct TagCells {
  int border = 0, side = 0;
};
TagCells tag_cells(const Target& target);

/// Whether a square of a checkerboard or ChArUco is black: column from the left, row from below,
/// with the outer squares.
bool is_black_square(const Target& target, int column, int row);

/// A rectangle of the print [m], in the frame of the target.
struct PrintedRectangle {
  Eigen::Vector2d lower_left, upper_right;
};

/// All that is black on the board. Rectangles do not overlap.
std::vector<PrintedRectangle> black_rectangles(const Target& target);

/// What the board covers, with its outer squares [m].
PrintedRectangle board_outline(const Target& target);

}  // namespace chasles
