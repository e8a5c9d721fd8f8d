#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/past/fixed_interval.hpp>
#include <chasles/filter/past/segment.hpp>

namespace chasles {

/// At the start of a segment: the cross-covariance U K of the landmarks that are away and return
/// later with its starts. Few directions of the state connect it with what left long before, so U
/// has few columns. Its rows are the places of these landmarks, and of some that have returned and
/// are of no use any more.
struct Connection {
  std::shared_ptr<const Eigen::MatrixXd> U_and_more;  ///< shared by successive segments
  Eigen::Index left = 0;                              ///< rows of U
  Eigen::MatrixXd K;
  std::vector<Eigen::Index> returned;  ///< places at the end of the segment before
  /// Where places are numbered anew at this start: those before, of the places that are left.
  std::optional<std::vector<Eigen::Index>> before = {};

  auto U() const { return U_and_more->topLeftCorner(left, K.rows()); }
  Eigen::Index places() const { return U_and_more->rows(); }  ///< with room for further ones
};

/// The numbers of all landmarks that return, rising.
std::vector<int> returning_numbers(const std::vector<Stretch>& stretches);

/// At the start of each segment, forwards through all of them. Directions that the others explain
/// to 1e-8 of the largest are left out. A landmark that leaves gets the next places, as many as it
/// has rows. Now and then those that have returned give theirs up, and the others are numbered
/// anew. So there are hardly more than landmarks away at one time.
std::vector<Connection> connections_of(const std::vector<Stretch>& stretches);

}  // namespace chasles
