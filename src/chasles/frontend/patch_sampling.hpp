#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

/// Sampling of the pixels of a patch; included only by the files that sample patches.
namespace chasles::sampling {

/// Whole pixels that a patch may move before its region is read again.
inline constexpr int kSlack = 2;
/// Deformations below this at a patch's edge are neglected [px].
inline constexpr float kMaxBend = 0.1F;
inline constexpr float kMaxBow = 0.05F;
/// Floats in a row of a region.
inline constexpr int kRegion = 32;

/// A part of an image as floats, read by the steps of one alignment.
struct Region {
  int x = 0, y = 0;  // of its first pixel in the image
  alignas(16) float value[kRegion * kRegion];
};

// A patch of side 23 with ring, slack and the pixel for interpolation.
static_assert(Patch::kMaxSide + 2 + 2 * kSlack + 1 <= kRegion);
// Columns beyond the patch have weight 0; those beyond the end of a row are the next row's.
static_assert(Patch::kMaxSide / 2 + 2 + kSlack < PyramidLevel::kPad);

/// Reads `Columns` columns, rounded up to whole vectors.
template <int Columns>
inline void read_region(const PyramidLevel& level, int x, int y, int rows, Region& region) {
  constexpr int columns = (Columns + 7) / 8 * 8;
  static_assert(columns <= kRegion);
  region.x = x;
  region.y = y;
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t* from = level.at(x, y + r);
    float* to = region.value + r * kRegion;
    for (int c = 0; c < columns; ++c) to[c] = from[c];
  }
}

inline bool inside(const PyramidLevel& level, const Eigen::Vector2f& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= static_cast<float>(level.width - 1) &&
         p.y() <= static_cast<float>(level.height - 1);
}

/// Bilinear weights of the four pixels around a point, and the position of the first of them.
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

/// The image at centre + o for all o of a square of `side` pixels, rows of `Lanes` floats.
template <int Lanes>
inline void sample_straight(const PyramidLevel& level, const Eigen::Vector2f& centre, int side,
                            float* out) {
  const Bilinear at(centre);
  Region region;
  read_region<Lanes + 1>(level, at.x - side / 2, at.y - side / 2, side + 1, region);
  interpolate<Lanes>(region, 0, 0, at, side, out);
}

/// Two neighbouring pixels, the left one in the low byte: one load instead of two.
inline std::uint32_t two_pixels(const std::uint8_t* left) {
  std::uint16_t both;
  std::memcpy(&both, left, sizeof both);
  const auto read = std::uint32_t{both};
  return std::endian::native == std::endian::little ? read : (read >> 8 | (read & 255) << 8);
}

/// The image at centre + A o, and with `Bowed` + bow (o_x^2, o_x o_y, o_y^2), for all o of a square
/// of `side` pixels, rows of `Lanes` floats: the slow path. It uses three loops per row: a separate
/// loop for the scalar loads lets the compiler vectorise the other two.
template <int Lanes, bool Bowed>
inline void sample_bent(const PyramidLevel& level, const Eigen::Vector2f& centre,
                        const PatchShape& shape, int side, float* out) {
  // Coordinates in the padded image are positive, so that a cast rounds down.
  constexpr auto pad = static_cast<float>(PyramidLevel::kPad);
  const float x_end = static_cast<float>(level.width) + 2 * pad - 1.01F;
  const float y_end = static_cast<float>(level.height) + 2 * pad - 1.01F;
  const int half = side / 2, stride = level.stride();
  const Eigen::Matrix2f& A = shape.A;
  const float A_xx = A(0, 0), A_xy = A(0, 1), A_yx = A(1, 0), A_yy = A(1, 1);
  const std::uint8_t* first = level.padded.data();
  alignas(16) int index[Lanes];
  alignas(16) float u[Lanes], v[Lanes];
  alignas(16) std::uint32_t four[Lanes];
  for (int r = 0; r < side; ++r) {
    const float o_y = static_cast<float>(r - half);
    float row_x = centre.x() + pad + A_xy * o_y, row_y = centre.y() + pad + A_yy * o_y;
    float by_x = A_xx, by_y = A_yx;  // of o_x in this row
    if constexpr (Bowed) {
      row_x += shape.bow(0, 2) * o_y * o_y;
      row_y += shape.bow(1, 2) * o_y * o_y;
      by_x += shape.bow(0, 1) * o_y;
      by_y += shape.bow(1, 1) * o_y;
    }
    for (int c = 0; c < Lanes; ++c) {
      const float o_x = static_cast<float>(c - half);
      float at_x = row_x + by_x * o_x, at_y = row_y + by_y * o_x;
      if constexpr (Bowed) {
        at_x += shape.bow(0, 0) * o_x * o_x;
        at_y += shape.bow(1, 0) * o_x * o_x;
      }
      const float x = std::min(std::max(at_x, 0.0F), x_end);
      const float y = std::min(std::max(at_y, 0.0F), y_end);
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      u[c] = x - static_cast<float>(i);
      v[c] = y - static_cast<float>(j);
      index[c] = j * stride + i;
    }
    for (int c = 0; c < Lanes; ++c) {
      const std::uint8_t* above = first + index[c];
      four[c] = two_pixels(above) | two_pixels(above + stride) << 16;
    }
    for (int c = 0; c < Lanes; ++c) {
      const auto pixel = [&](int i) { return static_cast<int>(four[c] >> 8 * i & 255); };
      const int p = pixel(0), p_right = pixel(1), q = pixel(2), q_right = pixel(3);
      const float above = static_cast<float>(p) + u[c] * static_cast<float>(p_right - p);
      const float below = static_cast<float>(q) + u[c] * static_cast<float>(q_right - q);
      out[r * Lanes + c] = above + v[c] * (below - above);
    }
  }
}

/// The same, rows of `Lanes` floats; uses the fast path if the shape deforms the patch by less than
/// kMaxBend, and the next faster one if its bow moves the edge by less than kMaxBow.
template <int Lanes>
inline void sample(const PyramidLevel& level, const Eigen::Vector2f& centre,
                   const PatchShape& shape, int side, float* out) {
  const float bend = (shape.A - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff();
  const auto edge = static_cast<float>(side / 2);
  if (shape.bow.cwiseAbs().maxCoeff() * edge * edge > kMaxBow) {
    sample_bent<Lanes, true>(level, centre, shape, side, out);
  } else if (bend * edge > kMaxBend) {
    sample_bent<Lanes, false>(level, centre, shape, side, out);
  } else {
    sample_straight<Lanes>(level, centre, side, out);
  }
}

}  // namespace chasles::sampling
