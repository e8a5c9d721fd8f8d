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

/// Deformations below this at a patch's edge are neglected [px].
inline constexpr float kMaxBend = 0.1F;
inline constexpr float kMaxBow = 0.05F;
/// Pixels in a row of a patch with its ring, for the derivatives.
inline constexpr int kRing = 8;

// Columns beyond the patch are read, too; those beyond the end of a row are the next row's.
static_assert(Patch::kMaxSide / 2 + 1 + kRing < PyramidLevel::kPad);

inline bool inside(const PyramidLevel& level, const Eigen::Vector2f& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= static_cast<float>(level.width - 1) &&
         p.y() <= static_cast<float>(level.height - 1);
}

/// A weight from 0 to 1 in 1/32768.
inline std::int16_t weight(float w) {
  return static_cast<std::int16_t>(std::min(static_cast<int>(w * 32768.0F + 0.5F), 32767));
}

/// a + w (b - a), rounded: one instruction multiplies and rounds (x86: pmulhrsw).
inline std::int16_t blend(std::int16_t a, std::int16_t b, std::int16_t w) {
  const auto difference = static_cast<std::int16_t>(b - a);
  const auto part = static_cast<std::int16_t>(((difference * w >> 14) + 1) >> 1);
  return static_cast<std::int16_t>(a + part);
}

/// A pixel of an image as one of a patch.
inline std::int16_t pixel_of(int grey) {
  return static_cast<std::int16_t>((grey - 128) * Patch::kUnit);
}

/// Bilinear weights of the four pixels around a point, and the position of the first of them.
struct Bilinear {
  explicit Bilinear(const Eigen::Vector2f& p)
      : x(static_cast<int>(std::floor(p.x()))),
        y(static_cast<int>(std::floor(p.y()))),
        u(weight(p.x() - static_cast<float>(x))),
        v(weight(p.y() - static_cast<float>(y))) {}
  int x, y;
  std::int16_t u, v;
};

/// The image at centre + o for all o of a square of `side` pixels, rows of `Lanes` pixels, those
/// from `columns` on 0.
template <int Lanes>
inline void sample_straight(const PyramidLevel& level, const Eigen::Vector2f& centre, int side,
                            int columns, std::int16_t* out) {
  const Bilinear at(centre);
  const std::uint8_t* from = level.at(at.x - side / 2, at.y - side / 2);
  const int stride = level.stride();
  alignas(32) std::int16_t above[Lanes], inside[Lanes];
  for (int c = 0; c < Lanes; ++c) inside[c] = c < columns ? -1 : 0;
  for (int c = 0; c < Lanes; ++c) above[c] = blend(pixel_of(from[c]), pixel_of(from[c + 1]), at.u);
  for (int r = 0; r < side; ++r) {
    from += stride;
    for (int c = 0; c < Lanes; ++c) {
      const std::int16_t below = blend(pixel_of(from[c]), pixel_of(from[c + 1]), at.u);
      out[r * Lanes + c] = static_cast<std::int16_t>(blend(above[c], below, at.v) & inside[c]);
      above[c] = below;
    }
  }
}

/// Two neighbouring pixels, the left one in the low byte: one load instead of two.
inline std::uint16_t two_pixels(const std::uint8_t* left) {
  std::uint16_t both;
  std::memcpy(&both, left, sizeof both);
  return std::endian::native == std::endian::little
             ? both
             : static_cast<std::uint16_t>(both >> 8 | (both & 255) << 8);
}

/// The image at centre + A o, and with `Bowed` + bow (o_x^2, o_x o_y, o_y^2), for all o of a square
/// of `side` pixels, rows of `Lanes` pixels: the slow path. It uses three loops per row: a separate
/// loop for the scalar loads lets the compiler vectorise the other two.
template <int Lanes, bool Bowed>
inline void sample_bent(const PyramidLevel& level, const Eigen::Vector2f& centre,
                        const PatchShape& shape, int side, std::int16_t* out) {
  // Coordinates in the padded image are positive, so that a cast rounds down.
  constexpr auto pad = static_cast<float>(PyramidLevel::kPad);
  const float x_end = static_cast<float>(level.width) + 2 * pad - 1.01F;
  const float y_end = static_cast<float>(level.height) + 2 * pad - 1.01F;
  const int half = side / 2, stride = level.stride();
  const Eigen::Matrix2f& A = shape.A;
  const float A_xx = A(0, 0), A_xy = A(0, 1), A_yx = A(1, 0), A_yy = A(1, 1);
  const std::uint8_t* first = level.padded.data();
  alignas(32) int index[Lanes];
  alignas(32) std::int16_t u[Lanes], v[Lanes];
  alignas(32) std::uint16_t upper[Lanes] = {}, lower[Lanes] = {};
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
      u[c] = weight(x - static_cast<float>(i));
      v[c] = weight(y - static_cast<float>(j));
      index[c] = j * stride + i;
    }
    for (int c = 0; c < side; ++c) {
      const std::uint8_t* above = first + index[c];
      upper[c] = two_pixels(above);
      lower[c] = two_pixels(above + stride);
    }
    for (int c = 0; c < Lanes; ++c) {
      const std::int16_t above = blend(pixel_of(upper[c] & 255), pixel_of(upper[c] >> 8), u[c]);
      const std::int16_t below = blend(pixel_of(lower[c] & 255), pixel_of(lower[c] >> 8), u[c]);
      out[r * Lanes + c] = blend(above, below, v[c]);
    }
  }
}

/// The same by the fastest path that the shape allows: a deformation that moves no pixel by more
/// than kMaxBend, and a bow that moves none by more than kMaxBow, are neglected.
template <int Lanes>
inline void sample(const PyramidLevel& level, const Eigen::Vector2f& centre,
                   const PatchShape& shape, int side, std::int16_t* out) {
  const float bend = (shape.A - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff();
  const auto edge = static_cast<float>(side / 2);
  if (shape.bow.cwiseAbs().maxCoeff() * edge * edge > kMaxBow) {
    sample_bent<Lanes, true>(level, centre, shape, side, out);
  } else if (bend * edge > kMaxBend) {
    sample_bent<Lanes, false>(level, centre, shape, side, out);
  } else {
    sample_straight<Lanes>(level, centre, side, Lanes, out);
  }
}

}  // namespace chasles::sampling
