#pragma once

#include <cstdint>
#include <vector>

#include <chasles/numeric/spline.hpp>
#include <chasles/sim/floor_plan.hpp>
#include <chasles/sim/inertial_path.hpp>
#include <chasles/sim/texture.hpp>
#include <chasles/sim/texture_materials.hpp>

namespace chasles {

/// A rectangle in the world, to be seen from one side: from where its edges lead to the right and
/// down. The edges are perpendicular to each other.
struct Surface {
  Eigen::Vector3d corner;  ///< the upper left one [m]
  Eigen::Vector3d right, down;
  Material material = Material::kWall;
};

/// What is rendered: rooms, closed on all sides, and what stands in them.
struct RenderWorld {
  FloorPlan plan;
  double floor = 0, ceiling = 0;  ///< heights [m]
  std::vector<Box> furniture;
  std::vector<Surface> surfaces;
  std::vector<Eigen::Vector3d> lamps;  ///< [m]
};

/// The rooms of a scene. hallway and walk: their corridors; turntable: the cube in a large room;
/// trajectory: a room about the way of `motion` with boxes and pillars at `seed`'s places, none
/// nearer than 0.8 m to the way.
RenderWorld make_render_world(const InertialSettings& settings, const Spline& motion);

/// Walls, floor and ceiling of the plan, the faces of the furniture, and lamps.
RenderWorld furnished(const FloorPlan& plan, double floor, double ceiling,
                      const std::vector<Box>& furniture);

/// Surfaces with their pictures, lit by the lamps.
struct PaintedWorld {
  std::vector<Surface> surfaces;
  std::vector<Texture> textures;  ///< one for each surface
  double texel = 0;               ///< the size that was used [m]
};

/// Paints all surfaces; texels are larger than `texel` [m] where there would be more than 120
/// millions. UsageError where they would be larger than 3 cm.
PaintedWorld paint_world(const RenderWorld& world, double texel, std::uint64_t seed);

}  // namespace chasles
