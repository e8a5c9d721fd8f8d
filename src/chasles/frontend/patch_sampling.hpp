#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

/// How the pixels of a patch are read; included by patch.cpp alone.
namespace chasles::sampling {

/// Whole pixels that a patch may move before its region is read again.
inline constexpr int kSlack = 2;
/// Bends below this at a patch's edge are left out [px].
inline constexpr float kMaxBend = 0.1F;
/// Floats in a row of a region.
inline constexpr int kRegion = 32;

/// A part of an image as floats: what the steps of one alignment look at.
struct Region {
  int x = 0, y = 0;  // of its first pixel in the image
  alignas(16) float value[kRegion * kRegion];
};

// A patch of side 23 with ring, slack and the pixel for interpolation.
static_assert(Patch::kMaxSide + 2 + 2 * kSlack + 1 <= kRegion);
// Columns beyond the patch weigh nothing; where they reach behind a row they are the next row's.
static_assert(Patch::kMaxSide / 2 + 2 + kSlack < PyramidLevel::kPad);

inline void read_region(const PyramidLevel& level, int x, int y, int rows, Region& region) {
  region.x = x;
  region.y = y;
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t* from = level.at(x, y + r);
    float* to = region.value + r * kRegion;
    for (int c = 0; c < kRegion; ++c) to[c] = from[c];
  }
}

inline bool inside(const PyramidLevel& level, const Eigen::Vector2f& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= static_cast<float>(level.width - 1) &&
         p.y() <= static_cast<float>(level.height - 1);
}

/// Bilinear weights of the four pixels around a point, and where the first of them lies.
struct Bilinear {
  explicit Bilinear(const Eigen::Vector2f& p)
      : x(static_cast<int>(std::floor(p.x()))),
        y(static_cast<int>(std::floor(p.y()))),
        u(p.x() - static_cast<float>(x)),
        v(p.y() - static_cast<float>(y)) {}
  int x, y;
  float u, v;
};

/// rows x Lanes values of the region, from its pixel (x, y), shifted by (u, v).
template <int Lanes>
inline void interpolate(const Region& region, int x, int y, const Bilinear& at, int rows,
                        float* out) {
  const float u = at.u, v = at.v;
  alignas(16) float above[Lanes];
  const float* from = region.value + y * kRegion + x;
  for (int c = 0; c < Lanes; ++c) above[c] = from[c] + u * (from[c + 1] - from[c]);
  for (int r = 0; r < rows; ++r) {
    from += kRegion;
    for (int c = 0; c < Lanes; ++c) {
      const float below = from[c] + u * (from[c + 1] - from[c]);
      out[r * Lanes + c] = above[c] + v * (below - above[c]);
      above[c] = below;
    }
  }
}

/// The image at centre + A o for all o of a square of `side` pixels, any A: the slow way.
inline void sample_bent(const PyramidLevel& level, const Eigen::Vector2f& centre,
                        const Eigen::Matrix2f& A, int side, float* out, int lanes) {
  // Coordinates in the padded image are positive there, so that a cast rounds them down.
  constexpr auto pad = static_cast<float>(PyramidLevel::kPad);
  const float x_end = static_cast<float>(level.width) + 2 * pad - 1.01F;
  const float y_end = static_cast<float>(level.height) + 2 * pad - 1.01F;
  const float half = static_cast<float>(side / 2);
  const std::uint8_t* first = level.padded.data();
  for (int r = 0; r < side; ++r) {
    const float o_y = static_cast<float>(r) - half;
    for (int c = 0; c < side; ++c) {
      const float o_x = static_cast<float>(c) - half;
      const float x = centre.x() + pad + A(0, 0) * o_x + A(0, 1) * o_y;
      const float y = centre.y() + pad + A(1, 0) * o_x + A(1, 1) * o_y;
      const float in_x = std::min(std::max(x, 0.0F), x_end);
      const float in_y = std::min(std::max(y, 0.0F), y_end);
      const int i = static_cast<int>(in_x), j = static_cast<int>(in_y);
      const float u = in_x - static_cast<float>(i), v = in_y - static_cast<float>(j);
      const std::uint8_t* p = first + static_cast<std::ptrdiff_t>(j) * level.stride() + i;
      const std::uint8_t* q = p + level.stride();
      const float above = static_cast<float>(p[0]) + u * static_cast<float>(p[1] - p[0]);
      const float below = static_cast<float>(q[0]) + u * static_cast<float>(q[1] - q[0]);
      out[r * lanes + c] = above + v * (below - above);
    }
  }
}

/// The same, rows of `Lanes` floats; quickly where A bends the patch by less than kMaxBend.
template <int Lanes>
inline void sample(const PyramidLevel& level, const Eigen::Vector2f& centre,
                   const Eigen::Matrix2f& A, int side, float* out) {
  const float bend = (A - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff();
  if (bend * static_cast<float>(side / 2) > kMaxBend) {
    sample_bent(level, centre, A, side, out, Lanes);
    return;
  }
  const Bilinear at(centre);
  Region region;
  read_region(level, at.x - side / 2, at.y - side / 2, side + 1, region);
  interpolate<Lanes>(region, 0, 0, at, side, out);
}

}  // namespace chasles::sampling
