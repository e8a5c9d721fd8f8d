#include <algorithm>
#include <cmath>

#include <chasles/sim/texture_materials.hpp>
#include <chasles/sim/texture_paint.hpp>

namespace chasles {
namespace {

// Noise at every scale that a near camera may resolve.
std::vector<NoiseLayer> layers(double strength) {
  return {{1.7, 10 * strength},  {0.6, 9 * strength},    {0.21, 9 * strength},
          {0.075, 9 * strength}, {0.028, 10 * strength}, {0.011, 10 * strength}};
}

void paint_bricks(Canvas& canvas, const PaintedPatch& wall, Dice& dice) {
  const double height = dice.between(0.07, 0.2), width = height * dice.between(2, 3);
  const double joint = 0.012, mean = dice.between(80, 150);
  paint(canvas, wall, mean - 45);
  int row = 0;
  for (double y = wall.y; y < wall.y + wall.height; y += height, ++row) {
    const double end = wall.x + wall.width;
    for (double x = wall.x - (row % 2 == 0 ? 0 : width / 2); x < end; x += width) {
      const double left = std::max(x, wall.x);
      tint(canvas, {left, y, std::min(x + width - joint, end) - left, height - joint},
           45 + dice.between(-30, 30));
    }
  }
}

void paint_pipes(Canvas& canvas, Dice& dice) {
  const int count = dice.choice(3);
  for (int i = 0; i < count; ++i) {
    const PaintedPatch pipe{0, dice.between(0.1, 0.4), canvas.width_m(), dice.between(0.02, 0.06)};
    paint(canvas, pipe, dice.between(30, 220));
  }
  const int upright = static_cast<int>(canvas.width_m() / 4);
  for (int i = 0; i < upright; ++i) {
    const PaintedPatch pipe{dice.between(0, canvas.width_m()), 0, dice.between(0.02, 0.05),
                            dice.between(0.5, 1) * canvas.height_m()};
    paint(canvas, pipe, dice.between(40, 215));
  }
}

// Paints an object on the wall from x on; returns its width.
double paint_item(Canvas& canvas, double x, double floor, Dice& dice) {
  const double pick = dice.between(0, 1);
  if (pick < 0.22) {
    const double width = dice.between(0.85, 1.1), height = std::min(2.1, floor - 0.05);
    paint_door(canvas, {x, floor - height, width, height}, dice);
    return width;
  }
  if (pick < 0.75) {
    const double width = dice.between(0.3, 1.1), height = width * dice.between(0.6, 1.5);
    const double middle = floor - dice.between(1.1, 1.9);
    paint_poster(canvas, {x, middle - height / 2, width, height}, dice);
    if (height < 0.6) {
      paint_poster(canvas, {x, middle + height / 2 + 0.12, width, height * 0.8}, dice);
    }
    return width;
  }
  const double size = dice.between(0.12, 0.45);  // cabinets and switches
  const PaintedPatch box{x, floor - dice.between(0.5, 1.8), size, size * dice.between(0.7, 1.6)};
  paint(canvas, box, dice.between(30, 220));
  paint_frame(canvas, box, 0.025, dice.between(20, 235));
  paint(canvas, {x + size * 0.3, box.y + size * 0.3, size * 0.3, size * 0.15}, 30);
  return size;
}

void paint_wall(Canvas& canvas, Dice& dice) {
  add_noise(canvas, layers(1), dice.bits());
  tint(canvas, {0, 0, canvas.width_m(), canvas.height_m()}, dice.between(-15, 35));
  const double width = canvas.width_m(), floor = canvas.height_m();
  for (double x = dice.between(-3, 4); x < width; x += dice.between(6, 14)) {
    paint_bricks(canvas, {x, 0, dice.between(1.5, 4), floor}, dice);
  }
  if (dice.chance(0.6)) {
    tint(canvas, {0, floor - 1, width, 1}, dice.between(-45, -20));
    paint(canvas, {0, floor - 1, width, 0.04}, dice.between(30, 200));
  }
  paint_pipes(canvas, dice);
  scatter_marks(canvas, 8, 0.012, 0.13, dice);
  for (double x = dice.between(0.1, 0.6); x < width - 0.4;) {
    x += paint_item(canvas, x, floor, dice) + dice.between(0.1, 0.9);
  }
  // Rows of posters above, where the wall is high.
  for (double y = floor - 3.6; y > 0.3; y -= dice.between(1.2, 2)) {
    for (double x = dice.between(0, 1.5); x < width; x += dice.between(0.8, 3)) {
      paint_poster(canvas, {x, y, dice.between(0.4, 1.3), dice.between(0.4, 1)}, dice);
    }
  }
  paint(canvas, {0, floor - 0.1, width, 0.1}, dice.between(30, 70));
}

void paint_floor(Canvas& canvas, Dice& dice) {
  add_noise(canvas, layers(0.9), dice.bits());
  const double tile = 0.2 + 0.1 * (1 + dice.choice(4)), joint = 0.012;
  const double contrast = dice.between(12, 32), grout = dice.between(35, 70);
  for (double y = 0; y < canvas.height_m(); y += tile) {
    for (double x = 0; x < canvas.width_m(); x += tile) {
      tint(canvas, {x, y, tile, tile}, dice.between(-contrast, contrast) - 10);
      paint(canvas, {x, y, tile, joint}, grout);
      paint(canvas, {x, y, joint, tile}, grout);
      if (dice.chance(0.06)) {
        paint(canvas, {x + joint, y + joint, tile - joint, tile - joint}, dice.between(30, 220));
      }
    }
  }
  scatter_marks(canvas, 6, 0.015, 0.14, dice);
  const auto mats = static_cast<int>(canvas.width_m() * canvas.height_m() / 12);
  for (int i = 0; i < mats; ++i) {
    paint_poster(canvas,
                 {dice.between(0, canvas.width_m()), dice.between(0, canvas.height_m()),
                  dice.between(0.4, 1.2), dice.between(0.4, 1.2)},
                 dice);
  }
}

void paint_ceiling(Canvas& canvas, const std::vector<Eigen::Vector2d>& lamps, Dice& dice) {
  add_noise(canvas, layers(0.6), dice.bits());
  tint(canvas, {0, 0, canvas.width_m(), canvas.height_m()}, 25);
  const double panel = dice.chance(0.5) ? 0.6 : 0.5;
  for (double y = 0; y < canvas.height_m(); y += panel) {
    for (double x = 0; x < canvas.width_m(); x += panel) {
      tint(canvas, {x, y, panel, panel}, dice.between(-15, 15));
      paint(canvas, {x, y, panel, 0.02}, 60);
      paint(canvas, {x, y, 0.02, panel}, 60);
      if (dice.chance(0.08)) {
        for (double slot = 0.08; slot < panel - 0.08; slot += 0.07) {
          paint(canvas, {x + 0.06, y + slot, panel - 0.1, 0.03}, 25);
        }
      }
    }
  }
  scatter_marks(canvas, 12, 0.012, 0.12, dice);
  for (const Eigen::Vector2d& lamp : lamps) {
    const PaintedPatch patch{lamp.x() - 0.5, lamp.y() - 0.2, 1, 0.4};
    paint(canvas, patch, 250, 0.1);
    paint_frame(canvas, patch, 0.04, 90);
  }
}

void paint_box(Canvas& canvas, Dice& dice) {
  add_noise(canvas, layers(1), dice.bits());
  const double width = canvas.width_m(), height = canvas.height_m();
  tint(canvas, {0, 0, width, height}, dice.between(-45, 45));
  const double plank = dice.between(0.08, 0.3);
  const bool upright = dice.chance(0.4);
  for (double at = 0; at < (upright ? width : height); at += plank) {
    const PaintedPatch whole =
        upright ? PaintedPatch{at, 0, plank, height} : PaintedPatch{0, at, width, plank};
    const PaintedPatch gap =
        upright ? PaintedPatch{at, 0, 0.012, height} : PaintedPatch{0, at, width, 0.012};
    tint(canvas, whole, dice.between(-25, 25));
    paint(canvas, gap, 25);
  }
  scatter_marks(canvas, 14, 0.012, 0.15, dice);
  const auto labels = static_cast<int>(std::min(20.0, 1 + width * height));
  for (int i = 0; i < labels; ++i) {
    const double size = std::min(0.5 * std::min(width, height), dice.between(0.15, 0.6));
    if (size < 0.08) continue;
    paint_poster(canvas,
                 {dice.between(0, width - size), dice.between(0, height - size), size,
                  size * dice.between(0.6, 1)},
                 dice);
  }
  paint_frame(canvas, {0, 0, width, height}, 0.03, dice.between(25, 225));
}

void paint_chessboard(Canvas& canvas) {
  constexpr double kField = 0.25;
  for (int j = 0; j * kField < canvas.height_m(); ++j) {
    for (int i = 0; i * kField < canvas.width_m(); ++i) {
      paint(canvas, {i * kField, j * kField, kField, kField}, (i + j) % 2 == 0 ? 40 : 210, 0);
    }
  }
}

}  // namespace

Canvas paint_surface(const Painting& p) {
  Canvas canvas = make_canvas(p.width_m, p.height_m, p.texel, 128);
  Dice dice(p.seed, p.number);
  if (p.material == Material::kWall) paint_wall(canvas, dice);
  if (p.material == Material::kFloor) paint_floor(canvas, dice);
  if (p.material == Material::kCeiling) paint_ceiling(canvas, p.lamps, dice);
  if (p.material == Material::kBox) paint_box(canvas, dice);
  if (p.material == Material::kChessboard) paint_chessboard(canvas);
  return canvas;
}

}  // namespace chasles
