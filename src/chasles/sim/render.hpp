#pragma once

#include <vector>

#include <chasles/sim/render_rays.hpp>
#include <chasles/sim/render_world.hpp>

namespace chasles {

/// Computes the light at each pixel, row by row, in shades of the textures (0 to 255).
///
/// Every ray meets the nearest surface that faces the camera. Blocks of 8 x 8 or 4 x 4 pixels that
/// see one surface only are shaded without a search. Others are searched pixel by pixel with four
/// rays each, so that outlines are smooth. Textures are sampled trilinearly, with up to four
/// samples along the longer axis of a pixel's footprint. A pixel that meets nothing is black.
void render(const PaintedWorld& world, const RayTable& rays, const SE3& world_T_cam,
            std::vector<float>& light);

/// The index of the surface that the ray through each pixel's centre meets, by the same search; -1
/// without a surface.
std::vector<int> visible_surfaces(const PaintedWorld& world, const RayTable& rays,
                                  const SE3& world_T_cam);

}  // namespace chasles
