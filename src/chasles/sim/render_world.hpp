#pragma once

#include <cstdint>
#include <vector>

#include <chasles/numeric/spline.hpp>
#include <chasles/sim/floor_plan.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/texture.hpp>
#include <chasles/sim/texture_materials.hpp>

namespace chasles {

/// A rectangle in the world, visible from the side from which its edges point right and down. The
/// edges are perpendicular to each other.
struct Surface {
  Eigen::Vector3d corner;  ///< the upper left one [m]
  Eigen::Vector3d right, down;
  Material material = Material::kWall;
};

/// The rendered scene: rooms, closed on all sides, and furniture.
struct RenderWorld {
  FloorPlan plan;
  double floor = 0, ceiling = 0;  ///< heights [m]
  std::vector<Box> furniture;
  std::vector<Surface> surfaces;
  std::vector<Eigen::Vector3d> lamps;  ///< [m]
};

/// The rooms of a scene. hallway and walk: their corridors; turntable: the cube in a large room;
/// trajectory: a room about the path of `motion` with boxes and pillars that `seed` places at least
/// 0.8 m from the path.
RenderWorld make_render_world(const InertialSettings& settings, const Spline& motion);

/// Walls, floor and ceiling of the plan, the faces of the furniture, and lamps.
RenderWorld furnished(const FloorPlan& plan, double floor, double ceiling,
                      const std::vector<Box>& furniture);

/// Surfaces with their textures, lit by the lamps.
struct PaintedWorld {
  std::vector<Surface> surfaces;
  std::vector<Texture> textures;  ///< one for each surface
  double texel = 0;               ///< texel size used [m]
};

/// How the pictures of surfaces depend on each other.
struct Decoration {
  /// Surfaces of one material have one picture, repeated to the right after this length [m]; 0: no.
  double period = 0;
  /// The share of each surface that has another picture than with 0: strips of 1 to 3 m, which the
  /// seed chooses.
  double changed = 0;
};

/// Paints all surfaces. Texels are larger than `texel` [m] if there would be more than 120 million.
/// Throws UsageError if they would be larger than 3 cm.
PaintedWorld paint_world(const RenderWorld& world, double texel, std::uint64_t seed,
                         const Decoration& decoration = {});

}  // namespace chasles
