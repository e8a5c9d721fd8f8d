#pragma once

#include <vector>

#include <chasles/sim/render_rays.hpp>
#include <chasles/sim/render_world.hpp>

namespace chasles {

/// The light that falls on each pixel, row by row, in shades of the surfaces' pictures (0 to 255).
///
/// Every ray meets the nearest surface that faces the camera. Blocks of 8 x 8 or 4 x 4 pixels
/// that see one surface only are shaded without a search; others are searched pixel by pixel with
/// four rays each, so that outlines are smooth. Pictures are sampled trilinearly, with up to four
/// samples along the longer axis of a pixel's footprint. A pixel that meets nothing is black.
void render(const PaintedWorld& world, const RayTable& rays, const SE3& world_T_cam,
            std::vector<float>& light);

/// The number of the surface that the ray of each pixel's middle meets, by the same search; -1
/// where there is none.
std::vector<int> visible_surfaces(const PaintedWorld& world, const RayTable& rays,
                                  const SE3& world_T_cam);

}  // namespace chasles
