#include <string_view>

#include <fmt/format.h>

#include <chasles/base/validate.hpp>
#include <chasles/target/marker_dictionary.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target.hpp>

namespace chasles {
namespace {

constexpr double kSmallest = 1e-4, kLargest = 10;  // [m]: of a tag or a square
constexpr int kMostColumns = 100;

void check_between(std::string_view name, double value, double low, double high,
                   std::string_view expected) {
  if (value >= low && value <= high) return;
  reject_value(name, number_text(value), expected);
}

void check_length(std::string_view name, double metres) {
  check_between(name, metres, kSmallest, kLargest,
                "metres between 0.0001 and 10 (millimetres divided by 1000)");
}

void check_counts(const Target& target, int least, std::string_view what) {
  const std::string expected =
      fmt::format("a whole number of {} from {} to {}", what, least, kMostColumns);
  check_between("columns", target.columns, least, kMostColumns, expected);
  check_between("rows", target.rows, least, kMostColumns, expected);
}

void check_tags(const Target& target) {
  const std::size_t most = target_dictionary(target).codes.size();
  const std::size_t tags = count_tags(target) + static_cast<std::size_t>(target.code_offset);
  if (tags <= most) return;
  reject_value(
      "columns and rows",
      fmt::format("{} x {} with tags up to number {}", target.columns, target.rows, tags - 1),
      fmt::format("at most {}, the last one of the dictionary", most - 1));
}

void check_april_grid(const Target& target) {
  check_counts(target, 1, "tags");
  check_length("tag_size", target.tag_size);
  check_between("tag_spacing", target.tag_spacing, 0.05, 2,
                "the gap between two tags divided by the size of a tag, from 0.05 to 2 (0.3 on "
                "Kalibr's boards)");
  check_between("code_offset", target.code_offset, 0, 586, "the number of a tag from 0 to 586");
  check_tags(target);
}

void check_charuco(const Target& target) {
  check_counts(target, 3, "squares");
  check_length("column_spacing", target.column_spacing);
  if (target.row_spacing != target.column_spacing) {
    reject_value("row_spacing", number_text(target.row_spacing),
                 fmt::format("{}, as column_spacing: ChArUco has squares",
                             number_text(target.column_spacing)));
  }
  check_between("tag_size", target.tag_size, 0.3 * target.column_spacing,
                0.95 * target.column_spacing,
                fmt::format("metres between 0.3 and 0.95 of the squares' {}",
                            number_text(target.column_spacing)));
  check_tags(target);
}

Eigen::Vector3d tag_corner(const Target& target, int tag, int corner) {
  const double step = target.tag_size * (1 + target.tag_spacing);
  const bool right = corner == 1 || corner == 2, up = corner >= 2;
  return {tag % target.columns * step + (right ? target.tag_size : 0),
          tag / target.columns * step + (up ? target.tag_size : 0), 0};
}

}  // namespace

void validate(const Target& target) {
  if (target.kind == TargetKind::april_grid) return check_april_grid(target);
  if (target.kind == TargetKind::charuco) return check_charuco(target);
  check_counts(target, 3, "inner corners");
  check_length("column_spacing", target.column_spacing);
  check_length("row_spacing", target.row_spacing);
}

std::vector<Eigen::Vector3d> Target::corners() const {
  std::vector<Eigen::Vector3d> result;
  if (kind == TargetKind::april_grid) {
    for (int id = 0; id < 4 * columns * rows; ++id)
      result.push_back(tag_corner(*this, id / 4, id % 4));
    return result;
  }
  const bool charuco = kind == TargetKind::charuco;
  const int across = charuco ? columns - 1 : columns, up = charuco ? rows - 1 : rows;
  for (int r = 0; r < up; ++r) {
    for (int c = 0; c < across; ++c) {
      result.emplace_back(c * column_spacing, (charuco ? up - 1 - r : r) * row_spacing, 0);
    }
  }
  return result;
}

bool Target::is_symmetric() const {
  return kind == TargetKind::checkerboard && (columns + rows) % 2 == 0;
}

}  // namespace chasles
