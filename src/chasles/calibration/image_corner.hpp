#pragma once

#include <Eigen/Core>

namespace chasles {

/// For programs whose pixels begin at the corner of the image: the centre of the first pixel there
/// [px]. Ours is (0, 0).
inline constexpr double kFirstPixelCentre = 0.5;

/// A pixel of ours as such programs have it.
inline Eigen::Vector2d from_corner(const Eigen::Vector2d& pixel) {
  return pixel.array() + kFirstPixelCentre;
}

}  // namespace chasles
