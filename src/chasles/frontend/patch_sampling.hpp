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
/// Pixels more than those of a patch in a row with its ring, for the derivatives.
inline constexpr int kRing = 8;

/// A pixel of an image as one of a patch.
inline std::int16_t pixel_of(int grey) {
  return static_cast<std::int16_t>((grey - 128) * Patch::kUnit);
}

/// A part of an image as pixels of patches, for rows of `Lanes` of them: read once for all steps of
/// one alignment.
template <int Lanes>
struct Region {
  static constexpr int kRow = Lanes + 8;
  static_assert(1 + 2 * kSlack <= 8);
  // A patch with its ring and slack is inside the padding. Columns beyond it are read, too; those
  // beyond the end of a row are the next row's.
  static_assert(Patch::kMaxSide / 2 + 3 + kSlack < PyramidLevel::kPad);

  int x = 0, y = 0;  // of its first pixel in the image
  alignas(32) std::int16_t value[(Patch::kMaxSide + 3 + 2 * kSlack) * kRow];

  void read(const PyramidLevel& level, int at_x, int at_y, int rows) {
    x = at_x;
    y = at_y;
    for (int r = 0; r < rows; ++r) {
      const std::uint8_t* from = level.at(x, y + r);
      std::int16_t* to = value + r * kRow;
      for (int c = 0; c < kRow; ++c) to[c] = pixel_of(from[c]);
    }
  }
};

inline bool inside(const PyramidLevel& level, const Eigen::Vector2f& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= static_cast<float>(level.width - 1) &&
         p.y() <= static_cast<float>(level.height - 1);
}

/// A weight from 0 to 1 in 1/32768.
inline std::int16_t weight(float w) {
  return static_cast<std::int16_t>(std::min(static_cast<int>(w * 32768.0F + 0.5F), 32767));
}

/// w a, rounded; w in 1/32768. One instruction multiplies and rounds (x86: pmulhrsw).
inline std::int16_t scaled(std::int16_t a, std::int16_t w) {
  return static_cast<std::int16_t>(((a * w >> 14) + 1) >> 1);
}

/// a + w (b - a), rounded.
inline std::int16_t blend(std::int16_t a, std::int16_t b, std::int16_t w) {
  return static_cast<std::int16_t>(a + scaled(static_cast<std::int16_t>(b - a), w));
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

/// rows x Lanes pixels of the region, from its pixel (x, y), shifted by the weights; those from
/// `columns` on are 0.
template <int Lanes>
inline void interpolate(const Region<Lanes>& region, int x, int y, const Bilinear& at, int rows,
                        int columns, std::int16_t* out) {
  constexpr int row = Region<Lanes>::kRow;
  alignas(32) std::int16_t above[Lanes], inside[Lanes];
  for (int c = 0; c < Lanes; ++c) inside[c] = c < columns ? -1 : 0;
  const std::int16_t* from = region.value + y * row + x;
  for (int c = 0; c < Lanes; ++c) above[c] = blend(from[c], from[c + 1], at.u);
  for (int r = 0; r < rows; ++r) {
    from += row;
    for (int c = 0; c < Lanes; ++c) {
      const std::int16_t below = blend(from[c], from[c + 1], at.u);
      out[r * Lanes + c] = static_cast<std::int16_t>(blend(above[c], below, at.v) & inside[c]);
      above[c] = below;
    }
  }
}

/// The image at centre + o for all o of a square of `side` pixels, rows of `Lanes` pixels, those
/// from `columns` on 0.
template <int Lanes>
inline void sample_straight(const PyramidLevel& level, const Eigen::Vector2f& centre, int side,
                            int columns, std::int16_t* out) {
  const Bilinear at(centre);
  Region<Lanes> region;
  region.read(level, at.x - side / 2, at.y - side / 2, side + 1);
  interpolate(region, 0, 0, at, side, columns, out);
}

/// Two neighbouring pixels, the left one in the low byte: one load instead of two.
inline std::uint16_t two_pixels(const std::uint8_t* left) {
  std::uint16_t both;
  std::memcpy(&both, left, sizeof both);
  return std::endian::native == std::endian::little
             ? both
             : static_cast<std::uint16_t>(both >> 8 | (both & 255) << 8);
}

/// Where the pixels of a bent patch are in the padded image, row by row of `Lanes`: the upper left
/// of the four neighbours, and the weights of the others.
template <int Lanes>
struct Places {
  static constexpr int kMost = (Patch::kMaxSide + 2) * Lanes;
  alignas(32) std::int32_t index[kMost];
  alignas(32) std::int16_t u[kMost], v[kMost];
};

/// Pixel coordinates in 1/65536: a whole part, and a weight.
inline constexpr float kFixed = 65536;

/// Of centre + A o, all in the padded image.
template <int Lanes>
inline void place_affine(const PyramidLevel& level, const Eigen::Vector2f& centre,
                         const Eigen::Matrix2f& A, int side, Places<Lanes>& places) {
  const Eigen::Vector2f first = centre.array() + static_cast<float>(PyramidLevel::kPad);
  const Eigen::Matrix2f steps = kFixed * A;
  const auto whole = [](float x) { return static_cast<std::int32_t>(std::lrint(x)); };
  const std::int32_t x_by_x = whole(steps(0, 0)), x_by_y = whole(steps(0, 1));
  const std::int32_t y_by_x = whole(steps(1, 0)), y_by_y = whole(steps(1, 1));
  const std::int32_t x_0 = whole(kFixed * first.x()), y_0 = whole(kFixed * first.y());
  const int half = side / 2, stride = level.stride();
  for (int r = 0; r < side; ++r) {
    const std::int32_t row_x = x_0 + (r - half) * x_by_y, row_y = y_0 + (r - half) * y_by_y;
    for (int c = 0; c < Lanes; ++c) {
      const std::int32_t x = row_x + (c - half) * x_by_x, y = row_y + (c - half) * y_by_x;
      places.u[r * Lanes + c] = static_cast<std::int16_t>(x >> 1 & 0x7fff);
      places.v[r * Lanes + c] = static_cast<std::int16_t>(y >> 1 & 0x7fff);
      places.index[r * Lanes + c] = (y >> 16) * stride + (x >> 16);
    }
  }
}

/// Of centre + A o + bow (o_x^2, o_x o_y, o_y^2), at the nearest pixel of the padded image where
/// that is outside it.
template <int Lanes>
inline void place_bowed(const PyramidLevel& level, const Eigen::Vector2f& centre,
                        const PatchShape& shape, int side, Places<Lanes>& places) {
  // Coordinates in the padded image are positive, so that a cast rounds down.
  constexpr auto pad = static_cast<float>(PyramidLevel::kPad);
  const float x_end = static_cast<float>(level.width) + 2 * pad - 1.01F;
  const float y_end = static_cast<float>(level.height) + 2 * pad - 1.01F;
  const int half = side / 2, stride = level.stride();
  const Eigen::Matrix2f& A = shape.A;
  for (int r = 0; r < side; ++r) {
    const float o_y = static_cast<float>(r - half);
    const float row_x = centre.x() + pad + (A(0, 1) + shape.bow(0, 2) * o_y) * o_y;
    const float row_y = centre.y() + pad + (A(1, 1) + shape.bow(1, 2) * o_y) * o_y;
    const float by_x = A(0, 0) + shape.bow(0, 1) * o_y, by_y = A(1, 0) + shape.bow(1, 1) * o_y;
    const float bow_x = shape.bow(0, 0), bow_y = shape.bow(1, 0);
    for (int c = 0; c < Lanes; ++c) {
      const float o_x = static_cast<float>(c - half);
      const float at_x = row_x + (by_x + bow_x * o_x) * o_x;
      const float at_y = row_y + (by_y + bow_y * o_x) * o_x;
      const float x = std::min(std::max(at_x, 0.0F), x_end);
      const float y = std::min(std::max(at_y, 0.0F), y_end);
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      places.u[r * Lanes + c] = weight(x - static_cast<float>(i));
      places.v[r * Lanes + c] = weight(y - static_cast<float>(j));
      places.index[r * Lanes + c] = j * stride + i;
    }
  }
}

/// Whether A maps a square of `Lanes` pixels and more around the centre into the padded image,
/// whose coordinates in 1/65536 are whole numbers of 32 bits.
template <int Lanes>
inline bool maps_inside(const PyramidLevel& level, const Eigen::Vector2f& centre,
                        const Eigen::Matrix2f& A) {
  const Eigen::Vector2f reach = A.cwiseAbs().rowwise().sum() * static_cast<float>(Lanes);
  constexpr auto pad = static_cast<float>(PyramidLevel::kPad) - 2;
  constexpr int kMost = 32767 - 2 * PyramidLevel::kPad;
  return level.width < kMost && level.height < kMost && centre.x() - reach.x() > -pad &&
         centre.y() - reach.y() > -pad &&
         centre.x() + reach.x() < static_cast<float>(level.width) + pad &&
         centre.y() + reach.y() < static_cast<float>(level.height) + pad;
}

/// The image at these places, rows of `Lanes` pixels. A separate loop for the scalar loads lets the
/// compiler vectorise the other one; it runs over all rows, because a vector cannot be read soon
/// after its elements were written.
template <int Lanes>
inline void sample_at(const PyramidLevel& level, const Places<Lanes>& places, int side,
                      std::int16_t* out) {
  const std::uint8_t* first = level.padded.data();
  const int stride = level.stride();
  alignas(32) std::uint16_t upper[Places<Lanes>::kMost], lower[Places<Lanes>::kMost];
  for (int i = 0; i < side * Lanes; ++i) {
    const std::uint8_t* above = first + places.index[i];
    upper[i] = two_pixels(above);
    lower[i] = two_pixels(above + stride);
  }
  for (int i = 0; i < side * Lanes; ++i) {
    const std::int16_t u = places.u[i];
    const std::int16_t above = blend(pixel_of(upper[i] & 255), pixel_of(upper[i] >> 8), u);
    const std::int16_t below = blend(pixel_of(lower[i] & 255), pixel_of(lower[i] >> 8), u);
    out[i] = blend(above, below, places.v[i]);
  }
}

/// The same by the fastest path that the shape allows: a deformation that moves no pixel by more
/// than kMaxBend, and a bow that moves none by more than kMaxBow, are neglected.
template <int Lanes>
inline void sample(const PyramidLevel& level, const Eigen::Vector2f& centre,
                   const PatchShape& shape, int side, std::int16_t* out) {
  const float bend = (shape.A - Eigen::Matrix2f::Identity()).cwiseAbs().maxCoeff();
  const auto edge = static_cast<float>(side / 2);
  const bool bowed = shape.bow.cwiseAbs().maxCoeff() * edge * edge > kMaxBow;
  if (!bowed && bend * edge <= kMaxBend) {
    return sample_straight<Lanes>(level, centre, side, Lanes, out);
  }
  Places<Lanes> places;
  if (!bowed && maps_inside<Lanes>(level, centre, shape.A)) {
    place_affine(level, centre, shape.A, side, places);
  } else {
    place_bowed(level, centre, shape, side, places);
  }
  sample_at(level, places, side, out);
}

}  // namespace chasles::sampling
