#include <chasles/target/marker_dictionary.hpp>
#include <chasles/target/tag_layout.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

PrintedRectangle square_at(const Vector2d& lower_left, double size) {
  return {lower_left, lower_left + Vector2d::Constant(size)};
}

// Runs of black cells of a tag, row by row.
void add_tag(const PrintedTag& tag, const TagCells& cells, double size,
             std::vector<PrintedRectangle>& result) {
  const double cell = size / cells.side;
  const int bits = cells.side - 2 * cells.border;
  const auto black = [&](int column, int row) {  // row from above
    const int c = column - cells.border, r = row - cells.border;
    if (c < 0 || r < 0 || c >= bits || r >= bits) return true;
    return (tag.code >> (bits * bits - 1 - (r * bits + c)) & 1) == 0;
  };
  for (int row = 0; row < cells.side; ++row) {
    for (int begin = 0, end = 0; begin < cells.side; begin = end + 1) {
      for (end = begin; end < cells.side && black(end, row);) ++end;
      if (end == begin) continue;
      const double y = (cells.side - 1 - row) * cell;
      result.push_back({tag.lower_left + Vector2d(begin * cell, y),
                        tag.lower_left + Vector2d(end * cell, y + cell)});
    }
  }
}

// The upper left square is black, but where the legacy pattern has it white.
bool has_marker(const Target& target, int column, int row_from_above) {
  const int shift = target.legacy_pattern && target.rows % 2 == 0 ? 1 : 0;
  return (column + row_from_above + shift) % 2 != 0;
}

PrintedTag april_tag(const Target& target, int tag, std::uint64_t code) {
  const double step = target.tag_size * (1 + target.tag_spacing);
  // OpenCV's AprilTags are turned by half a turn.
  const Eigen::Vector2i at(tag % target.columns, tag / target.columns);
  return {at.cast<double>() * step, 2 * at, turned(turned(code, 6), 6)};
}

}  // namespace

std::size_t count_tags(const Target& target) {
  if (target.kind == TargetKind::checkerboard) return 0;
  if (target.kind == TargetKind::april_grid) {
    return static_cast<std::size_t>(target.columns) * target.rows;
  }
  std::size_t count = 0;
  for (int r = 0; r < target.rows; ++r) {
    for (int c = 0; c < target.columns; ++c) count += has_marker(target, c, r) ? 1 : 0;
  }
  return count;
}

std::vector<PrintedTag> printed_tags(const Target& target) {
  std::vector<PrintedTag> result;
  if (target.kind == TargetKind::checkerboard) return result;
  const auto codes = target_dictionary(target).codes;
  if (target.kind == TargetKind::april_grid) {
    for (int tag = 0; tag < target.columns * target.rows; ++tag) {
      result.push_back(
          april_tag(target, tag, codes[static_cast<std::size_t>(target.code_offset + tag)]));
    }
    return result;
  }
  const double margin = (target.column_spacing - target.tag_size) / 2;
  for (int r = 0; r < target.rows; ++r) {
    for (int c = 0; c < target.columns; ++c) {
      if (!has_marker(target, c, r)) continue;
      const Vector2d square = Vector2d(c - 1, target.rows - 2 - r) * target.column_spacing;
      result.push_back({square + Vector2d::Constant(margin),
                        {c - 1, target.rows - 2 - r},
                        codes[result.size()]});
    }
  }
  return result;
}

CornerGrid corner_grid(const Target& target) {
  if (target.kind == TargetKind::april_grid) return {2 * target.columns, 2 * target.rows};
  if (target.kind == TargetKind::charuco) return {target.columns - 1, target.rows - 1};
  return {target.columns, target.rows};
}

bool is_in(const CornerGrid& grid, const Eigen::Vector2i& at) {
  return at.x() >= 0 && at.y() >= 0 && at.x() < grid.columns && at.y() < grid.rows;
}

int corner_id(const Target& target, const Eigen::Vector2i& at) {
  const CornerGrid grid = corner_grid(target);
  if (target.kind == TargetKind::charuco) return (grid.rows - 1 - at.y()) * grid.columns + at.x();
  if (target.kind == TargetKind::checkerboard) return at.y() * grid.columns + at.x();
  const bool right = at.x() % 2 != 0, up = at.y() % 2 != 0;
  const int corner = up ? (right ? 2 : 3) : (right ? 1 : 0);
  return 4 * (at.y() / 2 * target.columns + at.x() / 2) + corner;
}

bool is_dark_to_upper_right(const Target& target, const Eigen::Vector2i& at) {
  if (target.kind == TargetKind::charuco) return is_black_square(target, at.x() + 1, at.y() + 1);
  return (at.x() + at.y()) % 2 == 0;
}

TagCells tag_cells(const Target& target) {
  if (target.kind == TargetKind::checkerboard) return {};
  const int border = target.kind == TargetKind::april_grid ? 2 : 1;
  return {border, target_dictionary(target).side + 2 * border};
}

bool is_black_square(const Target& target, int column, int row) {
  if (target.kind == TargetKind::checkerboard) return (column + row) % 2 == 0;
  return !has_marker(target, column, target.rows - 1 - row);
}

std::vector<PrintedRectangle> black_rectangles(const Target& target) {
  std::vector<PrintedRectangle> result;
  for (const PrintedTag& tag : printed_tags(target)) {
    add_tag(tag, tag_cells(target), target.tag_size, result);
  }
  if (target.kind == TargetKind::april_grid) {
    const double gap = target.tag_size * target.tag_spacing, step = target.tag_size + gap;
    for (int r = 0; r <= target.rows; ++r) {
      for (int c = 0; c <= target.columns; ++c) {
        result.push_back(square_at(Vector2d(c, r) * step - Vector2d::Constant(gap), gap));
      }
    }
    return result;
  }
  const int more = target.kind == TargetKind::checkerboard ? 1 : 0;
  const Vector2d size(target.column_spacing, target.row_spacing);
  for (int r = 0; r < target.rows + more; ++r) {
    for (int c = 0; c < target.columns + more; ++c) {
      if (!is_black_square(target, c, r)) continue;
      const Vector2d lower_left = Vector2d(c - 1, r - 1).cwiseProduct(size);
      result.push_back({lower_left, lower_left + size});
    }
  }
  return result;
}

PrintedRectangle board_outline(const Target& target) {
  if (target.kind == TargetKind::april_grid) {
    const double gap = target.tag_size * target.tag_spacing, step = target.tag_size + gap;
    return {Vector2d::Constant(-gap), Vector2d(target.columns, target.rows) * step};
  }
  const int more = target.kind == TargetKind::checkerboard ? 1 : 0;
  const Vector2d size(target.column_spacing, target.row_spacing);
  return {-size, Vector2d(target.columns + more - 1, target.rows + more - 1).cwiseProduct(size)};
}

}  // namespace chasles
