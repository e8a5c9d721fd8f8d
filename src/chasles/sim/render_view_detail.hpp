#pragma once

#include <vector>

#include <chasles/sim/render_rays.hpp>
#include <chasles/sim/render_world.hpp>

namespace chasles {

/// A surface in a camera's view. For the ray r = (x, y, 1) in the camera's frame, w . r is the
/// inverse depth of its intersection with the surface's plane; ((u . r) / (w . r), (v . r) / (w .
/// r)) is the texel there.
struct SurfaceView {
  float u[3], v[3], w[3];
  float width, height;  ///< [texels]
  float corners[4][3];  ///< in the camera's frame [m]
  const Texture* texture;
  int surface;  ///< its number
};

/// A point of a surface: the texel (u, v), at inverse depth w [1/m].
struct SurfacePoint {
  float u, v, w;
};

inline float along(const float (&row)[3], float x, float y) {
  return row[0] * x + row[1] * y + row[2];
}

/// The surfaces that face the camera.
std::vector<SurfaceView> facing(const PaintedWorld& world, const SE3& world_T_cam);

/// Selects the candidates that rays within the bounds may meet first, as indices into `views`.
/// `alone`: there is one, and every ray meets it.
struct Candidates {
  std::vector<int> views;
  bool alone = false;
};
void select(const std::vector<SurfaceView>& views, const std::vector<int>& from,
            const RayBounds& bounds, Candidates& result);

/// The nearest candidate that the ray (x, y, 1) meets; nullptr without one.
const SurfaceView* nearest(const std::vector<SurfaceView>& views, const std::vector<int>& from,
                           float x, float y);

}  // namespace chasles
