#pragma once

#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/target/corner_lattice.hpp>
#include <chasles/target/tag_reader.hpp>
#include <chasles/target/target.hpp>

namespace chasles {

/// Where a lattice lies on a board: its positions turned counterclockwise, then moved.
struct BoardPlacement {
  int turn = 0;  ///< quarters
  Eigen::Vector2i offset{0, 0};
  int votes = 0;  ///< tags

  /// The place in the grid of corners (tag_layout.hpp).
  Eigen::Vector2i on_board(const Eigen::Vector2i& lattice) const;
};

/// Whether more than a few corners of the lattice are outside of the board: then it is another
/// board than that of the target.
bool reaches_beyond(const Target& target, const BoardPlacement& placement,
                    const CornerLattice& lattice);

/// A placement by tags.
struct TagPlacement {
  std::optional<BoardPlacement> placement;  ///< that of the most tags, if it is certain
  int read = 0;                             ///< tags, of any placement
};

/// By the tags in the quads of a lattice.
TagPlacement place_by_tags(const Target& target, const TagReader& reader, const GreyPlane& image,
                           const std::vector<SaddlePoint>& points, const std::vector<Quad>& quads,
                           const CornerLattice& lattice);

/// Of a checkerboard: where the lattice is as wide and high as the board, and two of three corners
/// are there. Where half a turn makes no difference, x is to the right in the image.
std::optional<BoardPlacement> place_checkerboard(const Target& target,
                                                 const std::vector<SaddlePoint>& points,
                                                 const std::vector<Quad>& quads,
                                                 const CornerLattice& lattice);

}  // namespace chasles
