#include <algorithm>
#include <cmath>

#include <chasles/base/interruption.hpp>
#include <chasles/sim/texture_paint.hpp>

namespace chasles {
namespace {

std::uint8_t shade(double grey) {
  return static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0));
}

// Noise value of a lattice point, from -1 to 1.
float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x8DA6B343U ^ y * 0xD8163841U ^ seed;
  for (int i = 0; i < 2; ++i) h = (h ^ h >> 15) * 0x2C1B3C6DU;
  h ^= h >> 16;
  return static_cast<float>(h) * 0x1p-31F - 1;
}

float smooth(float x) { return x * x * (3 - 2 * x); }

// One row of one layer: between lattice columns i and i + 1 lie the texels from i * cell on.
void add_layer(std::vector<float>& row, int y, float cell, float amplitude, std::uint32_t seed) {
  const float at = static_cast<float>(y) / cell;
  const auto j = static_cast<std::uint32_t>(at);
  const float b = smooth(at - static_cast<float>(j));
  const auto column = [&](std::uint32_t i) {
    const float low = lattice(i, j, seed), high = lattice(i, j + 1, seed);
    return amplitude * (low + b * (high - low));
  };
  const auto width = static_cast<int>(row.size());
  float left = column(0);
  int x = 0;
  for (std::uint32_t i = 0; x < width; ++i) {
    const float right = column(i + 1);
    const float begin = static_cast<float>(i) * cell;
    const int end = std::min(width, static_cast<int>(std::ceil(begin + cell)));
    for (; x < end; ++x) {
      row[static_cast<std::size_t>(x)] +=
          left + smooth((static_cast<float>(x) - begin) / cell) * (right - left);
    }
    left = right;
  }
}

struct Texels {
  int left, top, right, bottom;
};

Texels texels_of(const Canvas& canvas, const PaintedPatch& patch) {
  const auto at = [&](double metres, int most) {
    return static_cast<int>(std::clamp(std::round(metres / canvas.texel), 0.0, double{1} * most));
  };
  return {at(patch.x, canvas.width), at(patch.y, canvas.height),
          at(patch.x + patch.width, canvas.width), at(patch.y + patch.height, canvas.height)};
}

template <typename Change>
void change(Canvas& canvas, const PaintedPatch& patch, Change&& value) {
  const Texels t = texels_of(canvas, patch);
  for (int y = t.top; y < t.bottom; ++y) {
    std::uint8_t* row = canvas.pixels.data() + static_cast<std::size_t>(y) * canvas.width;
    for (int x = t.left; x < t.right; ++x) row[x] = value(x, y, row[x]);
  }
}

constexpr int kGrainEdge = 256;  // [texels]

// The fine noise of objects painted over the noise of a surface.
const Canvas& grain_tile() {
  static const Canvas tile = [] {
    constexpr double kTexel = 0.005;
    Canvas canvas = make_canvas(kGrainEdge * kTexel, kGrainEdge * kTexel, kTexel, 128);
    add_noise(canvas, {{0.2, 6}, {0.06, 6}, {0.02, 6}, {0.009, 6}}, 77);
    return canvas;
  }();
  return tile;
}

void print_lines(Canvas& canvas, const PaintedPatch& p, double ink, Dice& dice) {
  const double line = dice.between(0.035, 0.07);
  for (double y = p.y + line; y + line < p.y + p.height; y += 1.7 * line) {
    for (double x = p.x + line; x < p.x + p.width - 2 * line;) {
      const double word = std::min(dice.between(0.5, 4) * line, p.x + p.width - line - x);
      paint(canvas, {x, y, word, line * dice.between(0.5, 1)}, ink);
      x += word + line * dice.between(0.4, 1.2);
    }
  }
}

void blocks(Canvas& canvas, const PaintedPatch& p, Dice& dice) {
  const int columns = 2 + dice.choice(4), rows = 2 + dice.choice(4);
  const double w = p.width / columns, h = p.height / rows;
  for (int i = 0; i < columns * rows; ++i) {
    const int x = i % columns, y = i / columns;
    const double grey = dice.between(25, 235), inner = dice.between(25, 235);
    paint(canvas, {p.x + x * w, p.y + y * h, w, h}, grey);
    const PaintedPatch part{p.x + (x + dice.between(0, 0.5)) * w,
                            p.y + (y + dice.between(0, 0.5)) * h, w * dice.between(0.2, 0.5),
                            h * dice.between(0.2, 0.5)};
    paint(canvas, part, inner);
  }
}

void chessboard(Canvas& canvas, const PaintedPatch& p, double ink, Dice& dice) {
  const double field = std::min(p.width, p.height) / (4 + dice.choice(4));
  for (double y = p.y; y + field <= p.y + p.height; y += field) {
    for (double x = p.x; x + field <= p.x + p.width; x += field) {
      if (dice.chance(0.5)) paint(canvas, {x, y, field, field}, ink);
    }
  }
}

void rings(Canvas& canvas, const PaintedPatch& p, double ink, double paper, Dice& dice) {
  double radius = 0.45 * std::min(p.width, p.height);
  const double x = p.x + p.width / 2, y = p.y + p.height / 2;
  for (double grey = ink; radius > 0.02; grey = grey == ink ? paper : ink) {
    paint_disc(canvas, x, y, radius, radius, grey);
    radius *= dice.between(0.55, 0.85);
  }
}

void dots(Canvas& canvas, const PaintedPatch& p, Dice& dice) {
  const int count = 10 + dice.choice(20);
  for (int i = 0; i < count; ++i) {
    const double r = dice.between(0.02, 0.12) * std::min(p.width, p.height);
    const double x = p.x + dice.between(r, p.width - r), y = p.y + dice.between(r, p.height - r);
    const double squeezed = r * dice.between(0.5, 1);
    paint_disc(canvas, x, y, r, squeezed, dice.between(20, 235));
  }
}

}  // namespace

Canvas make_canvas(double width_m, double height_m, double texel, std::uint8_t grey) {
  const auto texels = [&](double metres) {
    return std::max(2, static_cast<int>(std::ceil(metres / texel - 1e-6)));
  };
  Canvas canvas{.width = texels(width_m), .height = texels(height_m), .texel = texel, .pixels = {}};
  canvas.pixels.assign(static_cast<std::size_t>(canvas.width) * canvas.height, grey);
  return canvas;
}

void add_noise(Canvas& canvas, const std::vector<NoiseLayer>& layers, std::uint32_t seed) {
  std::vector<float> noise(static_cast<std::size_t>(canvas.width));
  for (int y = 0; y < canvas.height; ++y) {
    interruption_point();
    std::ranges::fill(noise, 0.5F);
    std::uint32_t of_layer = seed;
    for (const NoiseLayer& layer : layers) {
      const double cell = layer.cell / canvas.texel;
      // Details finer than the texels are not visible.
      if (cell < 1.5) continue;
      add_layer(noise, y, static_cast<float>(cell), static_cast<float>(layer.amplitude), of_layer);
      of_layer += 0x9E3779B9U;
    }
    std::uint8_t* row = canvas.pixels.data() + static_cast<std::size_t>(y) * canvas.width;
    for (int x = 0; x < canvas.width; ++x) {
      const float grey = static_cast<float>(row[x]) + noise[static_cast<std::size_t>(x)];
      row[x] = static_cast<std::uint8_t>(std::clamp(grey, 0.0F, 255.0F));
    }
  }
}

void paint(Canvas& canvas, const PaintedPatch& patch, double grey, double grain) {
  const Canvas& noise = grain_tile();
  change(canvas, patch, [&](int x, int y, double) {
    const double at =
        noise.pixels[static_cast<std::size_t>(y % kGrainEdge * kGrainEdge + x % kGrainEdge)];
    return shade(grey + grain * (at - 128));
  });
}

void tint(Canvas& canvas, const PaintedPatch& patch, double shades) {
  change(canvas, patch, [&](int, int, double old) { return shade(old + shades); });
}

void paint_disc(Canvas& canvas, double x, double y, double radius_x, double radius_y, double grey) {
  const PaintedPatch box{x - radius_x, y - radius_y, 2 * radius_x, 2 * radius_y};
  change(canvas, box, [&](int i, int j, std::uint8_t old) {
    const double a = ((i + 0.5) * canvas.texel - x) / radius_x;
    const double b = ((j + 0.5) * canvas.texel - y) / radius_y;
    return a * a + b * b < 1 ? shade(grey) : old;
  });
}

void paint_frame(Canvas& canvas, const PaintedPatch& p, double width, double grey) {
  paint(canvas, {p.x, p.y, p.width, width}, grey);
  paint(canvas, {p.x, p.y + p.height - width, p.width, width}, grey);
  paint(canvas, {p.x, p.y, width, p.height}, grey);
  paint(canvas, {p.x + p.width - width, p.y, width, p.height}, grey);
}

void paint_poster(Canvas& canvas, const PaintedPatch& patch, Dice& dice) {
  const bool light = dice.chance(0.6);
  const double paper = light ? dice.between(170, 230) : dice.between(20, 80);
  const double ink = light ? dice.between(15, 80) : dice.between(160, 235);
  paint(canvas, patch, paper);
  const double edge = 0.06 * std::min(patch.width, patch.height);
  const PaintedPatch inside{patch.x + 2 * edge, patch.y + 2 * edge, patch.width - 4 * edge,
                            patch.height - 4 * edge};
  const int sort = dice.choice(5);
  if (sort == 0) print_lines(canvas, inside, ink, dice);
  if (sort == 1) blocks(canvas, inside, dice);
  if (sort == 2) chessboard(canvas, inside, ink, dice);
  if (sort == 3) rings(canvas, inside, ink, paper, dice);
  if (sort == 4) dots(canvas, inside, dice);
  paint_frame(canvas, patch, edge, dice.between(20, 235));
}

void paint_door(Canvas& canvas, const PaintedPatch& p, Dice& dice) {
  const double leaf = dice.between(60, 200);
  const double frame = leaf > 120 ? leaf - dice.between(50, 90) : leaf + dice.between(50, 90);
  paint(canvas, p, leaf);
  paint_frame(canvas, {p.x, p.y, p.width, p.height + 0.09}, 0.09, frame);
  const double handle = dice.chance(0.5) ? p.x + 0.13 : p.x + p.width - 0.25;
  paint(canvas, {handle, p.y + p.height - 1.05, 0.12, 0.03}, leaf > 120 ? 20 : 235);
  paint(canvas, {p.x + p.width / 2 - 0.1, p.y + 0.35, 0.2, 0.09}, 230);
  print_lines(canvas, {p.x + p.width / 2 - 0.12, p.y + 0.32, 0.24, 0.14}, 25, dice);
  if (dice.chance(0.4)) {
    const PaintedPatch window{p.x + 0.3, p.y + 0.55, p.width - 0.6, dice.between(0.4, 0.9)};
    paint(canvas, window, dice.between(20, 235));
    paint_frame(canvas, window, 0.03, frame);
  }
  paint(canvas, {p.x + 0.09, p.y + p.height - 0.25, p.width - 0.18, 0.2}, frame);
}

void scatter_marks(Canvas& canvas, double per_square_metre, double smallest, double largest,
                   Dice& dice) {
  const double area = canvas.width_m() * canvas.height_m();
  const auto count = static_cast<int>(std::min(1e6, per_square_metre * area));
  for (int i = 0; i < count; ++i) {
    // Many small ones and few large ones.
    const double part = dice.between(0, 1);
    const double size = smallest + (largest - smallest) * part * part * part;
    const double x = dice.between(0, canvas.width_m()), y = dice.between(0, canvas.height_m());
    const double grey = dice.chance(0.5) ? dice.between(35, 95) : dice.between(160, 225);
    if (dice.chance(0.35)) {
      paint_disc(canvas, x, y, size / 2, size / 2 * dice.between(0.6, 1), grey);
    } else {
      paint(canvas, {x, y, size, size * dice.between(0.4, 1.6)}, grey);
    }
  }
}

}  // namespace chasles
