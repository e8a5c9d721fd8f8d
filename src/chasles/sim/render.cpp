#include <algorithm>
#include <cmath>
#include <numeric>

#include <chasles/sim/render.hpp>
#include <chasles/sim/render_view_detail.hpp>

namespace chasles {
namespace {

constexpr float kMostTaps = 4;

// The footprint of a pixel on the texture, an ellipse: samples along its longer axis, each of
// extent 2^lod.
struct Footprint {
  float lod, axis_u, axis_v;
  int taps;
};

SurfacePoint point_at(const SurfaceView& view, float x, float y) {
  const float w = along(view.w, x, y), inverse = 1 / w;
  return {along(view.u, x, y) * inverse, along(view.v, x, y) * inverse, w};
}

// The singular value decomposition of d texel / d pixel.
Footprint footprint(const SurfaceView& s, const SurfacePoint& p, const RayBlock& block) {
  const float inverse = 1 / p.w;
  const float u_x = (s.u[0] - p.u * s.w[0]) * inverse, u_y = (s.u[1] - p.u * s.w[1]) * inverse;
  const float v_x = (s.v[0] - p.v * s.w[0]) * inverse, v_y = (s.v[1] - p.v * s.w[1]) * inverse;
  const float a = u_x * block.x_u + u_y * block.y_u, b = u_x * block.x_v + u_y * block.y_v;
  const float c = v_x * block.x_u + v_y * block.y_u, d = v_x * block.x_v + v_y * block.y_v;
  const float uu = a * a + b * b, vv = c * c + d * d, uv = a * c + b * d;
  const float mean = (uu + vv) / 2, det = a * d - b * c;
  const float apart = std::sqrt(std::max(0.0F, mean * mean - det * det));
  const float major = std::sqrt(mean + apart), minor = std::sqrt(std::max(0.0F, mean - apart));
  const float extent = std::max({minor, major / kMostTaps, 1.0F});
  float axis_u = uv, axis_v = mean + apart - uu;
  if (uu > vv) axis_u = mean + apart - vv, axis_v = uv;
  const float norm = std::sqrt(axis_u * axis_u + axis_v * axis_v);
  const float scale = norm > 0 ? major / norm : 0;
  const float taps = std::clamp(std::ceil(major / extent - 0.25F), 1.0F, kMostTaps);
  return {std::log2(extent), axis_u * scale, axis_v * scale, static_cast<int>(taps)};
}

float sampled(const SurfaceView& s, const SurfacePoint& p, const Footprint& f, float lod) {
  const auto tap = [&](float part) {
    const float u = std::clamp(p.u + part * f.axis_u, 0.0F, s.width);
    const float v = std::clamp(p.v + part * f.axis_v, 0.0F, s.height);
    return sample(*s.texture, u, v, lod);
  };
  if (f.taps == 1) return tap(0);
  const float step = 1 / static_cast<float>(f.taps);
  float sum = 0;
  for (int k = 0; k < f.taps; ++k) sum += tap((static_cast<float>(k) + 0.5F) * step - 0.5F);
  return sum * step;
}

float shaded(const SurfaceView& s, const RayBlock& block, float x, float y) {
  const SurfacePoint p = point_at(s, x, y);
  const Footprint f = footprint(s, p, block);
  return sampled(s, p, f, f.lod);
}

// The whole block sees one surface: the extent of the samples is interpolated from its corners.
void shade_block(const SurfaceView& s, const RayTable& rays, const RayBlock& block, float* light) {
  const auto at = [&](int u, int v) {
    const std::size_t i = rays.at(u, v);
    return footprint(s, point_at(s, rays.x[i], rays.y[i]), block);
  };
  const int right = block.right - 1, bottom = block.bottom - 1;
  const Footprint middle = at((block.left + right + 1) / 2, (block.top + bottom + 1) / 2);
  const float a = at(block.left, block.top).lod, b = at(right, block.top).lod;
  const float c = at(block.left, bottom).lod, d = at(right, bottom).lod;
  const float across = 1 / static_cast<float>(std::max(1, right - block.left));
  const float down = 1 / static_cast<float>(std::max(1, bottom - block.top));
  for (int v = block.top; v <= bottom; ++v) {
    const float y = static_cast<float>(v - block.top) * down;
    const float first = a + y * (c - a), slope = (b + y * (d - b) - first) * across;
    for (int u = block.left; u <= right; ++u) {
      const std::size_t i = rays.at(u, v);
      const float lod = first + slope * static_cast<float>(u - block.left);
      light[i] = sampled(s, point_at(s, rays.x[i], rays.y[i]), middle, lod);
    }
  }
}

// Four rays, no two in one row or column of the pixel. Rays that meet one surface are shaded once.
float search_pixel(const std::vector<SurfaceView>& views, const std::vector<int>& from,
                   const RayBlock& block, float x, float y) {
  constexpr float kAside[4][2] = {
      {-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}};
  const SurfaceView* met[4];
  float xs[4], ys[4];
  for (int k = 0; k < 4; ++k) {
    xs[k] = x + kAside[k][0] * block.x_u + kAside[k][1] * block.x_v;
    ys[k] = y + kAside[k][0] * block.y_u + kAside[k][1] * block.y_v;
    met[k] = nearest(views, from, xs[k], ys[k]);
  }
  if (met[0] && met[0] == met[1] && met[0] == met[2] && met[0] == met[3]) {
    return shaded(*met[0], block, x, y);
  }
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    if (met[k]) sum += shaded(*met[k], block, xs[k], ys[k]);
  }
  return sum / 4;
}

// Calls visit(part) for the parts of an edge of `step` pixels that lie in the block.
template <typename Visit>
void for_each_part(const RayTable& rays, const std::vector<RayBlock>& parts, int step,
                   const RayBlock& block, Visit&& visit) {
  const int columns = (rays.width + step - 1) / step;
  for (int v = block.top; v < block.bottom; v += step) {
    for (int u = block.left; u < block.right; u += step) {
      visit(parts[static_cast<std::size_t>(v / step * columns + u / step)]);
    }
  }
}

// Calls visit(block, candidates) for blocks that together cover the image: small ones where more
// than one surface may be visible.
template <typename Visit>
void for_each_block(const std::vector<SurfaceView>& views, const RayTable& rays, Visit&& visit) {
  std::vector<int> all(views.size());
  std::iota(all.begin(), all.end(), 0);
  Candidates of_tile, of_block, of_quarter;
  for (const RayBlock& tile : rays.tiles) {
    select(views, all, tile.bounds, of_tile);
    for_each_part(rays, rays.blocks, kBlockEdge, tile, [&](const RayBlock& block) {
      select(views, of_tile.views, block.bounds, of_block);
      if (of_block.alone) {
        visit(block, of_block);
        return;
      }
      for_each_part(rays, rays.quarters, kQuarterEdge, block, [&](const RayBlock& quarter) {
        select(views, of_block.views, quarter.bounds, of_quarter);
        visit(quarter, of_quarter);
      });
    });
  }
}

}  // namespace

void render(const PaintedWorld& world, const RayTable& rays, const SE3& world_T_cam,
            std::vector<float>& light) {
  light.resize(rays.x.size());
  const std::vector<SurfaceView> views = facing(world, world_T_cam);
  for_each_block(views, rays, [&](const RayBlock& block, const Candidates& candidates) {
    if (candidates.alone) {
      const auto only = static_cast<std::size_t>(candidates.views.front());
      shade_block(views[only], rays, block, light.data());
      return;
    }
    for (int v = block.top; v < block.bottom; ++v) {
      for (int u = block.left; u < block.right; ++u) {
        const std::size_t i = rays.at(u, v);
        light[i] = search_pixel(views, candidates.views, block, rays.x[i], rays.y[i]);
      }
    }
  });
}

std::vector<int> visible_surfaces(const PaintedWorld& world, const RayTable& rays,
                                  const SE3& world_T_cam) {
  std::vector<int> result(rays.x.size());
  const std::vector<SurfaceView> views = facing(world, world_T_cam);
  for_each_block(views, rays, [&](const RayBlock& block, const Candidates& candidates) {
    for (int v = block.top; v < block.bottom; ++v) {
      for (int u = block.left; u < block.right; ++u) {
        const std::size_t i = rays.at(u, v);
        const SurfaceView* met = nearest(views, candidates.views, rays.x[i], rays.y[i]);
        result[i] = met ? met->surface : -1;
      }
    }
  });
  return result;
}

}  // namespace chasles
