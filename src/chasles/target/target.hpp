#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/settings.hpp>
#include <chasles/base/time.hpp>

namespace chasles {

enum class TargetKind {
  april_grid,    ///< AprilTags (36h11, border of two bits) with black squares between their corners
  checkerboard,  ///< black and white squares
  charuco,       ///< a checkerboard with ArUco markers in its white squares
};

/// The names of Kalibr's `target_type`, and ours.
template <>
struct Choices<TargetKind> {
  static constexpr std::array list = {Choice{TargetKind::april_grid, "aprilgrid"},
                                      Choice{TargetKind::checkerboard, "checkerboard"},
                                      Choice{TargetKind::charuco, "charuco"}};
};

/// A calibration target: a flat board with corners at known places, as printed.
///
/// Frame `target`: x right, y up, z out of the board, as seen from the front [m].
struct Target {
  TargetKind kind = TargetKind::april_grid;
  /// april_grid: tags. checkerboard: inner corners, one less than squares. charuco: squares.
  int columns = 0, rows = 0;
  /// Sides of a tag or marker with its black border [m]. None in a checkerboard.
  double tag_size = 0;
  /// april_grid: the gap between two tags, as a part of tag_size; the black squares fill it.
  double tag_spacing = 0;
  /// april_grid: the number of the first tag in the family 36h11; the others follow.
  int code_offset = 0;
  /// checkerboard and charuco: the distance of two corners along x and along y [m]. Equal for
  /// charuco.
  double column_spacing = 0, row_spacing = 0;
  /// charuco: OpenCV's name of the markers' dictionary, e.g. "DICT_5X5_1000"; the first marker has
  /// its code 0.
  std::string dictionary = {};
  /// charuco with an even number of rows: the upper left square is white, as OpenCV before 4.6
  /// printed it, and later with setLegacyPattern(true). Otherwise that square is black.
  bool legacy_pattern = false;

  /// Where the corners are: p_target [m], z = 0. The index is the corner's id:
  ///
  /// - april_grid: 4 tag + corner. Tags go from the lower left to the right, then up; a tag's
  ///   corners from the lower left counterclockwise. The first corner is the origin.
  /// - checkerboard: row by row from the lower left, which is the origin. Where the board does not
  ///   from the same turned by half a turn, the outer square at the lower left is black.
  /// - charuco: the inner corners row by row from the *upper* left, as OpenCV (from 4.7) numbers
  ///   them. The lower left one is the origin.
  std::vector<Eigen::Vector3d> corners() const;

  /// Whether the board looks the same after half a turn (a checkerboard whose columns + rows are
  /// even): then the ids of a view go up in the image, and may change between views.
  bool is_symmetric() const;

  bool operator==(const Target&) const = default;
};

/// Throws UsageError for numbers of which no board can be made: names, values found and expected.
void validate(const Target& target);

/// The corners of a target that an image shows.
struct TargetView {
  Time time{};
  int camera = 0;        ///< index in its rig
  std::vector<int> ids;  ///< of Target::corners(), rising
  std::vector<Eigen::Vector2d>
      pixels;  ///< one for each id [px]; the first pixel's centre is (0, 0)
};

}  // namespace chasles
