#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/sim/render_world.hpp>
#include <chasles/sim/texture_paint.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr double kMostTexels = 120e6;
constexpr double kLargestTexel = 0.03;  // [m]
constexpr double kLightCell = 0.25;     // [m], or this many texels:
constexpr double kLightTexels = 40;
constexpr double kLightReach = 7;  // [m]
constexpr double kAmbient = 0.7;

double area_of(const std::vector<Surface>& surfaces) {
  double area = 0;
  for (const Surface& s : surfaces) area += s.right.norm() * s.down.norm();
  return area;
}

double fitting_texel(const RenderWorld& world, double texel) {
  const double area = area_of(world.surfaces);
  const double least = std::sqrt(area / kMostTexels);
  if (least <= kLargestTexel) return std::max(texel, least);
  throw UsageError(fmt::format(
      "the scene's walls measure {:.3g} m^2: too large for images; expected at most {:.3g} m^2, a "
      "shorter path",
      area, kMostTexels * kLargestTexel * kLargestTexel));
}

// Ambient light, and light of the lamps by Lambert's law. It decreases with the square of the
// distance; lamps in higher rooms are brighter.
double light_at(const Vector3d& p, const Vector3d& normal, const RenderWorld& world) {
  double light = kAmbient;
  const double height = std::max(1.0, (world.ceiling - world.floor) / 2.8);
  const double reach = kLightReach * height;
  for (const Vector3d& lamp : world.lamps) {
    const Vector3d ray = lamp - p;
    const double square = ray.squaredNorm();
    if (square > reach * reach) continue;
    const double facing = std::max(0.0, normal.dot(ray) / std::sqrt(square + 1e-9));
    light += 1.7 * std::pow(height, 0.8) * facing / (square + 1);
  }
  return std::min(light, 1.35);
}

// Corners of a room are darker.
double shade_at(const Surface& surface, const Vector3d& p, const RenderWorld& world) {
  if (surface.material != Material::kWall) return 1;
  const double near = std::min(p.z() - world.floor, world.ceiling - p.z());
  return 1 - 0.3 * std::exp(-near / 0.2);
}

// The light on the corners of a grid of cells over the surface.
struct LightMap {
  double cell;  // [m]
  int columns, rows;
  std::vector<float> light;
  const float* row(int j) const { return light.data() + static_cast<std::size_t>(j) * columns; }
};

LightMap light_map(const Surface& surface, const RenderWorld& world, double texel) {
  const double cell = std::max(kLightCell, kLightTexels * texel);
  const auto nodes = [cell](double metres) {
    return static_cast<int>(std::ceil(metres / cell)) + 2;
  };
  const Vector3d right = surface.right.normalized(), down = surface.down.normalized();
  const Vector3d normal = -right.cross(down);
  LightMap map{cell, nodes(surface.right.norm()), nodes(surface.down.norm()), {}};
  for (int j = 0; j < map.rows; ++j) {
    interruption_point();
    for (int i = 0; i < map.columns; ++i) {
      const Vector3d p = surface.corner + cell * (i * right + j * down);
      map.light.push_back(
          static_cast<float>(light_at(p, normal, world) * shade_at(surface, p, world)));
    }
  }
  return map;
}

void light_up(Canvas& canvas, const LightMap& map) {
  const auto per_cell = static_cast<float>(canvas.texel / map.cell);
  std::vector<float> row(static_cast<std::size_t>(map.columns));
  for (int y = 0; y < canvas.height; ++y) {
    interruption_point();
    const float at = (static_cast<float>(y) + 0.5F) * per_cell;
    const auto j = std::min(static_cast<int>(at), map.rows - 2);
    const float b = at - static_cast<float>(j);
    for (int i = 0; i < map.columns; ++i) {
      row[static_cast<std::size_t>(i)] = map.row(j)[i] + b * (map.row(j + 1)[i] - map.row(j)[i]);
    }
    std::uint8_t* pixels = canvas.pixels.data() + static_cast<std::size_t>(y) * canvas.width;
    for (int x = 0; x < canvas.width; ++x) {
      const float across = (static_cast<float>(x) + 0.5F) * per_cell;
      const auto i = static_cast<std::size_t>(std::min(static_cast<int>(across), map.columns - 2));
      const float a = across - static_cast<float>(i);
      const float lit = static_cast<float>(pixels[x]) * (row[i] + a * (row[i + 1] - row[i])) + 0.5F;
      pixels[x] = static_cast<std::uint8_t>(std::min(lit, 255.0F));
    }
  }
}

// The positions of the lamps in the surface's own axes.
std::vector<Eigen::Vector2d> lamps_on(const Surface& surface, const RenderWorld& world) {
  std::vector<Eigen::Vector2d> result;
  if (surface.material != Material::kCeiling) return result;
  for (const Vector3d& lamp : world.lamps) {
    const Vector3d from = lamp - surface.corner;
    result.emplace_back(from.dot(surface.right.normalized()), from.dot(surface.down.normalized()));
  }
  return result;
}

// To the right.
Canvas repeated(const Canvas& part, double width_m) {
  Canvas whole = make_canvas(width_m, part.height_m(), part.texel, 0);
  for (int y = 0; y < whole.height; ++y) {
    for (int x = 0; x < whole.width; ++x) {
      whole.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(whole.width) +
                   static_cast<std::size_t>(x)] =
          part.pixels[static_cast<std::size_t>(std::min(y, part.height - 1)) *
                          static_cast<std::size_t>(part.width) +
                      static_cast<std::size_t>(x % part.width)];
    }
  }
  return whole;
}

// Strips across the longer edge, each with this probability, show the other picture.
void change_strips(Canvas& canvas, const Canvas& other, double probability, Dice& dice) {
  const bool upright = canvas.width >= canvas.height;
  const int length = upright ? canvas.width : canvas.height;
  for (int begin = 0, end = 0; begin < length; begin = end) {
    end = std::min(length, begin + static_cast<int>(dice.between(1, 3) / canvas.texel) + 1);
    if (!dice.chance(probability)) continue;
    for (int y = upright ? 0 : begin; y < (upright ? canvas.height : end); ++y) {
      const std::ptrdiff_t row = std::ptrdiff_t{y} * canvas.width;
      std::copy(other.pixels.begin() + row + (upright ? begin : 0),
                other.pixels.begin() + row + (upright ? end : canvas.width),
                canvas.pixels.begin() + row + (upright ? begin : 0));
    }
  }
}

Texture painted(const Surface& surface, std::uint64_t number, const RenderWorld& world,
                double texel, std::uint64_t seed, const Decoration& decoration) {
  constexpr std::uint64_t kOtherPicture = 0xe0000000, kWhere = 0xd0000000;
  const bool repeats = decoration.period > 0;
  const double width = surface.right.norm();
  const auto picture = [&](std::uint64_t of) {
    const Canvas canvas = paint_surface({.material = surface.material,
                                         .width_m = repeats ? decoration.period : width,
                                         .height_m = surface.down.norm(),
                                         .texel = texel,
                                         .seed = seed,
                                         .number = of,
                                         .lamps = lamps_on(surface, world)});
    return repeats ? repeated(canvas, width) : canvas;
  };
  const std::uint64_t first = repeats ? 0 : number;
  Canvas canvas = picture(first);
  if (decoration.changed > 0) {
    Dice dice(seed, kWhere + number);
    change_strips(canvas, picture(kOtherPicture + first), decoration.changed, dice);
  }
  light_up(canvas, light_map(surface, world, texel));
  return make_texture(canvas);
}

}  // namespace

PaintedWorld paint_world(const RenderWorld& world, double texel, std::uint64_t seed,
                         const Decoration& decoration) {
  PaintedWorld result{
      .surfaces = world.surfaces, .textures = {}, .texel = fitting_texel(world, texel)};
  for (std::uint64_t i = 0; i < world.surfaces.size(); ++i) {
    interruption_point(i, world.surfaces.size());
    result.textures.push_back(painted(world.surfaces[i], i, world, result.texel, seed, decoration));
  }
  return result;
}

}  // namespace chasles
