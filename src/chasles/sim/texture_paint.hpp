#pragma once

#include <cstdint>
#include <vector>

#include <chasles/numeric/random.hpp>
#include <chasles/sim/texture.hpp>

namespace chasles {

// Elements of the pictures of surfaces. Lengths are in metres from the upper left corner. Parts
// outside the canvas are cut off.

/// A sequence of random numbers, for elements that are painted in sequence.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t surface) : random_{seed}, surface_(surface) {}

  double between(double low, double high) {
    return low + (high - low) * random_.uniform(Stream::kTexture, surface_, count_++);
  }
  /// 0 ... count - 1.
  int choice(int count) { return static_cast<int>(between(0, count)); }
  bool chance(double probability) { return between(0, 1) < probability; }
  std::uint32_t bits() { return static_cast<std::uint32_t>(between(0, 4294967295.0)); }

 private:
  Random random_;
  std::uint64_t surface_;
  std::uint32_t count_ = 0;
};

/// A uniform canvas of at least that size, at least two texels each way.
Canvas make_canvas(double width_m, double height_m, double texel, std::uint8_t grey);

/// A layer of value noise: random numbers on a lattice with smooth interpolation.
struct NoiseLayer {
  double cell = 0;       ///< of the lattice [m]
  double amplitude = 0;  ///< [shades]
};

/// Adds layers of noise to all of the canvas.
void add_noise(Canvas& canvas, const std::vector<NoiseLayer>& layers, std::uint32_t seed);

/// An upright rectangle.
struct PaintedPatch {
  double x = 0, y = 0, width = 0, height = 0;
};

/// Paints a patch, with fine noise of 8 shades times `grain`.
void paint(Canvas& canvas, const PaintedPatch& patch, double grey, double grain = 1);

/// Adds shades to a patch.
void tint(Canvas& canvas, const PaintedPatch& patch, double shades);

/// Paints a disc, or an ellipse where the radii differ.
void paint_disc(Canvas& canvas, double x, double y, double radius_x, double radius_y, double grey);

/// Paints a rectangle's outline inwards.
void paint_frame(Canvas& canvas, const PaintedPatch& patch, double width, double grey);

/// A poster of one of several kinds: lines of print, blocks, a chessboard with gaps, rings, dots.
void paint_poster(Canvas& canvas, const PaintedPatch& patch, Dice& dice);

/// A door in its frame, with handle, number plate and possibly a window; its lower edge is at y +
/// height.
void paint_door(Canvas& canvas, const PaintedPatch& patch, Dice& dice);

/// Small patches and dots of any shade, scattered evenly over the canvas.
void scatter_marks(Canvas& canvas, double per_square_metre, double smallest, double largest,
                   Dice& dice);

}  // namespace chasles
