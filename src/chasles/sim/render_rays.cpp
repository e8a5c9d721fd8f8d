#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/camera/anchor_face.hpp>
#include <chasles/camera/distortion.hpp>
#include <chasles/sim/render_rays.hpp>

namespace chasles {
namespace {

// The derivative at the middle pixel, by differences to its neighbours.
void set_slopes(const RayTable& rays, RayBlock& block) {
  const int u = (block.left + block.right) / 2, v = (block.top + block.bottom) / 2;
  const int a = std::max(u - 1, 0), b = std::min(u + 1, rays.width - 1);
  const int c = std::max(v - 1, 0), d = std::min(v + 1, rays.height - 1);
  const auto slope = [&](const std::vector<float>& of, int u0, int v0, int u1, int v1) {
    const int pixels = std::max(1, u1 - u0 + v1 - v0);
    return (of[rays.at(u1, v1)] - of[rays.at(u0, v0)]) / static_cast<float>(pixels);
  };
  block.x_u = slope(rays.x, a, v, b, v);
  block.x_v = slope(rays.x, u, c, u, d);
  block.y_u = slope(rays.y, a, v, b, v);
  block.y_v = slope(rays.y, u, c, u, d);
}

void set_bounds(const RayTable& rays, RayBlock& block) {
  const std::size_t first = rays.at(block.left, block.top);
  RayBounds b{rays.x[first], rays.x[first], rays.y[first], rays.y[first]};
  for (int v = block.top; v < block.bottom; ++v) {
    for (int u = block.left; u < block.right; ++u) {
      const float x = rays.x[rays.at(u, v)], y = rays.y[rays.at(u, v)];
      b = {std::min(b.x_min, x), std::max(b.x_max, x), std::min(b.y_min, y), std::max(b.y_max, y)};
    }
  }
  const float dx = 0.6F * (std::abs(block.x_u) + std::abs(block.x_v));
  const float dy = 0.6F * (std::abs(block.y_u) + std::abs(block.y_v));
  block.bounds = {b.x_min - dx, b.x_max + dx, b.y_min - dy, b.y_max + dy};
}

std::vector<RayBlock> make_blocks(const RayTable& rays, int edge) {
  std::vector<RayBlock> blocks;
  for (int top = 0; top < rays.height; top += edge) {
    for (int left = 0; left < rays.width; left += edge) {
      RayBlock block{.left = left,
                     .top = top,
                     .right = std::min(left + edge, rays.width),
                     .bottom = std::min(top + edge, rays.height),
                     .bounds = {},
                     .x_u = 0,
                     .x_v = 0,
                     .y_u = 0,
                     .y_v = 0};
      set_slopes(rays, block);
      set_bounds(rays, block);
      blocks.push_back(block);
    }
  }
  return blocks;
}

void add_blocks(RayTable& rays) {
  rays.blocks = make_blocks(rays, kBlockEdge);
  rays.tiles = make_blocks(rays, kTileEdge);
  rays.quarters = make_blocks(rays, kQuarterEdge);
}

// Whether the lens, which does not fold over, has this pixel at 90 degrees from its axis or beyond.
bool is_beside(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr double kNearlyBeside = 1e3;  // tangent of 89.94 degrees
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx,
                               (pixel.y() - camera.cy) / camera.fy);
  const double across = target.norm();
  if (!(across > 0)) return false;
  const auto edge = distort(camera, kNearlyBeside / across * target);
  return edge && edge->xy.norm() <= across;
}

[[noreturn]] void reject_pixel(const Camera& camera, int u, int v) {
  throw UsageError(
      fmt::format("the camera's pixel ({}, {}) has no ray: its lens model folds over before; "
                  "expected coefficients that are valid in all of the image of {} x {} px",
                  u, v, camera.width, camera.height));
}

RayTable empty_table(const Camera& camera) {
  return {.width = camera.width,
          .height = camera.height,
          .x = {},
          .y = {},
          .tiles = {},
          .blocks = {},
          .quarters = {}};
}

bool is_all_in_front(const Camera& camera) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      if (!unproject(camera, {u, v})) return false;
    }
  }
  return true;
}

// Of all pixels; zero where there is none.
std::vector<Eigen::Vector3d> bearings_of(const Camera& camera) {
  std::vector<Eigen::Vector3d> bearings;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d pixel(u, v);
      const auto found = bearing(camera, pixel);
      if (!found && !is_beside(camera, pixel)) reject_pixel(camera, u, v);
      bearings.push_back(found ? found->bearing : Eigen::Vector3d::Zero());
    }
  }
  return bearings;
}

// A direction that is hardly in front of the face has no meaning there.
Eigen::Vector2f in_face(const Eigen::Vector3d& direction) {
  constexpr double kFlat = 0.1;
  if (!(direction.z() > kFlat)) return Eigen::Vector2f::Zero();
  return (direction.head<2>() / direction.z()).cast<float>();
}

bool has_pixel(const RayBlock& block, const RayTable& rays, const std::vector<char>& listed) {
  for (int v = block.top; v < block.bottom; ++v) {
    for (int u = block.left; u < block.right; ++u) {
      if (listed[rays.at(u, v)]) return true;
    }
  }
  return false;
}

RayFace make_face(AnchorFace face, const Camera& camera,
                  const std::vector<Eigen::Vector3d>& bearings) {
  const Eigen::Matrix3d face_R = face_R_cam(face);
  RayFace result{.cam_R_face = face_R.transpose(), .rays = empty_table(camera), .pixels = {}};
  std::vector<char> listed(bearings.size(), 0);
  for (std::size_t i = 0; i < bearings.size(); ++i) {
    const Eigen::Vector2f xy = in_face(face_R * bearings[i]);
    result.rays.x.push_back(xy.x());
    result.rays.y.push_back(xy.y());
    if (bearings[i].isZero() || face_towards(bearings[i]) != face) continue;
    listed[i] = 1;
    result.pixels.push_back(i);
  }
  add_blocks(result.rays);
  std::erase_if(result.rays.tiles,
                [&](const RayBlock& tile) { return !has_pixel(tile, result.rays, listed); });
  return result;
}

}  // namespace

RayTable make_rays(const Camera& camera) {
  RayTable rays = empty_table(camera);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto ray = unproject(camera, {u, v});
      if (!ray) reject_pixel(camera, u, v);
      rays.x.push_back(static_cast<float>(ray->ray.x()));
      rays.y.push_back(static_cast<float>(ray->ray.y()));
    }
  }
  add_blocks(rays);
  return rays;
}

std::vector<RayFace> make_faces(const Camera& camera) {
  std::vector<RayFace> faces;
  if (!sees_beside(camera) || is_all_in_front(camera)) {
    faces.push_back({.rays = make_rays(camera), .pixels = {}});
    faces.front().pixels.resize(faces.front().rays.x.size());
    std::iota(faces.front().pixels.begin(), faces.front().pixels.end(), std::size_t{0});
    return faces;
  }
  const std::vector<Eigen::Vector3d> bearings = bearings_of(camera);
  for (int i = 0; i < kAnchorFaces; ++i) {
    RayFace face = make_face(static_cast<AnchorFace>(i), camera, bearings);
    if (!face.pixels.empty()) faces.push_back(std::move(face));
  }
  return faces;
}

RayTable rotated_lines(const RayTable& rays, const Lines& lines,
                       const std::vector<Eigen::Matrix3f>& rotations) {
  const int count = lines.last - lines.first;
  RayTable part{.width = lines.are_rows ? rays.width : count,
                .height = lines.are_rows ? count : rays.height,
                .x = {},
                .y = {},
                .tiles = {},
                .blocks = {},
                .quarters = {}};
  for (int v = 0; v < part.height; ++v) {
    for (int u = 0; u < part.width; ++u) {
      const std::size_t i =
          lines.are_rows ? rays.at(u, v + lines.first) : rays.at(u + lines.first, v);
      const Eigen::Matrix3f& R = rotations[static_cast<std::size_t>(lines.are_rows ? v : u)];
      const Eigen::Vector3f ray = R * Eigen::Vector3f(rays.x[i], rays.y[i], 1);
      part.x.push_back(ray.x() / ray.z());
      part.y.push_back(ray.y() / ray.z());
    }
  }
  add_blocks(part);
  return part;
}

}  // namespace chasles
