#include <algorithm>

#include <Eigen/Geometry>

#include <chasles/sim/render_view_detail.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr double kOnPlane = 1e-6;     // [m]: a camera nearer to the plane sees the surface edge on
constexpr float kBehind = 1 - 1e-4F;  // of a plane, in depths
constexpr float kSeam = 0.02F;        // [texels], so that there is no gap between neighbours

void store(const Vector3d& from, float (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

SurfaceView view_of(const Vector3d& corner, const Vector3d& right, const Vector3d& down,
                    const Vector3d& w, const Texture& texture, double texel, int number) {
  SurfaceView view{};
  const Vector3d a = right.normalized() / texel, b = down.normalized() / texel;
  store(w, view.w);
  store(a - a.dot(corner) * w, view.u);
  store(b - b.dot(corner) * w, view.v);
  view.width = static_cast<float>(right.norm() / texel);
  view.height = static_cast<float>(down.norm() / texel);
  store(corner, view.corners[0]);
  store(corner + right, view.corners[1]);
  store(corner + down, view.corners[2]);
  store(corner + right + down, view.corners[3]);
  view.texture = &texture;
  view.surface = number;
  return view;
}

// Whether the whole surface is on the other side of one of the bounding planes.
bool outside(const SurfaceView& view, const RayBounds& bounds) {
  int left = 0, right = 0, above = 0, below = 0, behind = 0;
  for (const auto& p : view.corners) {
    left += p[0] < bounds.x_min * p[2] ? 1 : 0;
    right += p[0] > bounds.x_max * p[2] ? 1 : 0;
    above += p[1] < bounds.y_min * p[2] ? 1 : 0;
    below += p[1] > bounds.y_max * p[2] ? 1 : 0;
    behind += p[2] <= 0 ? 1 : 0;
  }
  return left == 4 || right == 4 || above == 4 || below == 4 || behind == 4;
}

bool meets(const SurfaceView& view, float x, float y, float seam) {
  const float w = along(view.w, x, y);
  if (!(w > 0)) return false;
  const float u = along(view.u, x, y), v = along(view.v, x, y);
  return u >= -seam * w && v >= -seam * w && u <= (view.width + seam) * w &&
         v <= (view.height + seam) * w;
}

bool covers(const SurfaceView& view, const RayBounds& b) {
  return meets(view, b.x_min, b.y_min, 0) && meets(view, b.x_max, b.y_min, 0) &&
         meets(view, b.x_min, b.y_max, 0) && meets(view, b.x_max, b.y_max, 0);
}

// For a surface that covers the bounds: whether it occludes the other one completely. Either the
// other plane is farther everywhere (inverse depths are linear in x and y), or the other surface
// lies behind the front one's plane.
bool hides(const SurfaceView& front, const SurfaceView& other, const RayBounds& b) {
  const auto nearer = [&](float x, float y) {
    return along(front.w, x, y) >= along(other.w, x, y);
  };
  if (nearer(b.x_min, b.y_min) && nearer(b.x_max, b.y_min) && nearer(b.x_min, b.y_max) &&
      nearer(b.x_max, b.y_max)) {
    return true;
  }
  return std::ranges::all_of(other.corners, [&](const auto& p) {
    return front.w[0] * p[0] + front.w[1] * p[1] + front.w[2] * p[2] >= kBehind;
  });
}

}  // namespace

std::vector<SurfaceView> facing(const PaintedWorld& world, const SE3& world_T_cam) {
  const SE3 cam_T_world = world_T_cam.inverse();
  std::vector<SurfaceView> views;
  for (std::size_t i = 0; i < world.surfaces.size(); ++i) {
    const Surface& s = world.surfaces[i];
    const Vector3d corner = cam_T_world * s.corner;
    const Vector3d right = cam_T_world.R * s.right, down = cam_T_world.R * s.down;
    const Vector3d away = right.cross(down).normalized();
    const double distance = away.dot(corner);
    if (distance <= kOnPlane) continue;
    views.push_back(view_of(corner, right, down, away / distance, world.textures[i], world.texel,
                            static_cast<int>(i)));
  }
  return views;
}

void select(const std::vector<SurfaceView>& views, const std::vector<int>& from,
            const RayBounds& bounds, Candidates& result) {
  std::vector<int>& left = result.views;
  left.clear();
  result.alone = false;
  for (const int i : from) {
    if (!outside(views[static_cast<std::size_t>(i)], bounds)) left.push_back(i);
  }
  for (std::size_t k = 0; k < left.size(); ++k) {
    const int i = left[k];
    const SurfaceView& front = views[static_cast<std::size_t>(i)];
    if (!covers(front, bounds)) continue;
    std::erase_if(left, [&](int j) {
      return j != i && hides(front, views[static_cast<std::size_t>(j)], bounds);
    });
    // The removed surfaces may have been in front of it.
    k = static_cast<std::size_t>(std::ranges::find(left, i) - left.begin());
    result.alone = left.size() == 1;
  }
}

const SurfaceView* nearest(const std::vector<SurfaceView>& views, const std::vector<int>& from,
                           float x, float y) {
  const SurfaceView* best = nullptr;
  float most = 0;
  for (const int i : from) {
    const SurfaceView& view = views[static_cast<std::size_t>(i)];
    const float w = along(view.w, x, y);
    if (w > most && meets(view, x, y, kSeam)) {
      most = w;
      best = &view;
    }
  }
  return best;
}

}  // namespace chasles
