#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace chasles::dense {

/// The upper triangle of a square P (a reference to one) <- the lower one.
template <class Square>
void mirror_lower_of(Square& P) {
  // Tiles small enough that source and destination stay in the first-level cache.
  constexpr Eigen::Index kTile = 32;
  const Eigen::Index n = P.rows();
  for (Eigen::Index j = 0; j < n; j += kTile) {
    const Eigen::Index width = std::min(kTile, n - j);
    P.block(j, j, width, width).template triangularView<Eigen::StrictlyUpper>() =
        P.block(j, j, width, width).transpose();
    for (Eigen::Index i = j + width; i < n; i += kTile) {
      const Eigen::Index height = std::min(kTile, n - i);
      P.block(j, i, width, height) = P.block(i, j, height, width).transpose();
    }
  }
}

}  // namespace chasles::dense
