#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/sim/texture.hpp>

namespace chasles {

/// The appearance of a surface.
enum class Material {
  kWall,        ///< plaster, partly brick, with doors, posters, cables and sockets
  kFloor,       ///< tiles with joints, mats and stains
  kCeiling,     ///< panels with holes, vents and lamps
  kBox,         ///< crates and furniture: planks, labels, drawers
  kChessboard,  ///< squares of 0.25 m, dark at the upper left corner; for measurements
};

/// A surface to be painted.
struct Painting {
  Material material = Material::kWall;
  double width_m = 0, height_m = 0;
  double texel = 0;                    ///< [m]
  std::uint64_t seed = 0, number = 0;  ///< select the picture: no two are alike
  std::vector<Eigen::Vector2d> lamps;  ///< positions of lamps on a ceiling [m]
};

/// The surface's reflectance, 0 to 255.
Canvas paint_surface(const Painting& painting);

}  // namespace chasles
