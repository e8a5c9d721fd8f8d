#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/saddle_points.hpp>
#include <chasles/target/tag_layout.hpp>

namespace chasles {

/// The tag that a quad shows.
struct ReadTag {
  int tag = 0;         ///< index in printed_tags()
  int upper_left = 0;  ///< which corner of the quad is the tag's upper left one
  int wrong_bits = 0;  ///< of the code
};

/// Reads the tags of a target in the quads of an image: the bits by the homography of the quad's
/// corners, against thresholds between its own black and white.
class TagReader {
 public:
  explicit TagReader(const Target& target);

  /// `corners` clockwise as seen in the image: of the tag's black border for an AprilGrid, of the
  /// white square around the marker for ChArUco. None where there is no such tag, or it may be
  /// another one of the board.
  std::optional<ReadTag> read(const GreyPlane& image,
                              const std::array<Eigen::Vector2d, 4>& corners) const;

  /// Whether a single tag with so many wrong bits is proof enough: fewer than one in ten million
  /// random patterns are as near to one of the codes.
  bool proves(int wrong_bits) const;

 private:
  Target target_;
  std::vector<PrintedTag> tags_;
  TagCells cells_;
  int most_wrong_ = 0;  ///< bits that are corrected
};

}  // namespace chasles
