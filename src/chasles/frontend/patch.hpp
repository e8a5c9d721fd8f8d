#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {

/// How a patch lies in the image that it is taken from: its pixel at offset o is the image at
/// centre
/// + A o + bow (o_x^2, o_x o_y, o_y^2).
struct PatchShape {
  Eigen::Matrix2f A = Eigen::Matrix2f::Identity();
  Eigen::Matrix<float, 2, 3> bow = Eigen::Matrix<float, 2, 3>::Zero();  ///< [1/px]

  PatchShape() = default;
  PatchShape(const Eigen::Matrix2f& straight) : A(straight) {}  // NOLINT(*-explicit-*)
  PatchShape(const Eigen::Matrix2f& straight, const Eigen::Matrix<float, 2, 3>& curved)
      : A(straight), bow(curved) {}
};

/// A square patch of an image, prepared for the inverse compositional Lucas & Kanade method (Baker
/// & Matthews, IJCV 2004). It estimates a shift under unknown gain and offset of the grey levels.
///
/// The other image is J(p + o) = gain * T(o + p - p_true) + offset. Gain and offset are eliminated
/// from the normal equations once. A step then needs the sums of J and of its products with three
/// fixed patches. Pixels are integers of 16 bits, and their sums are exact: the same numbers on
/// every processor, in any order.
struct Patch {
  static constexpr int kMaxSide = 23;
  /// Steps of a grey level. Sums of kMaxSide^2 products of two pixels fit into 32 bits.
  static constexpr int kUnit = 15;
  static constexpr int kMaxLanes = 24;
  using Pixels = std::int16_t[kMaxSide * kMaxLanes];

  /// Pixels in a row of a patch; those beyond its side are 0.
  static constexpr int lanes(int side) { return side <= 16 ? 16 : kMaxLanes; }

  int side = 0;                     ///< [px], odd
  alignas(32) Pixels value;         ///< T - 128 [grey levels / kUnit]
  alignas(32) Pixels d_x;           ///< dT/dx [grey levels / kUnit / px]
  alignas(32) Pixels d_y;           ///< dT/dy, likewise
  double mean = 0;                  ///< of `value`
  double energy = 0;                ///< sum of (value - mean)^2
  Eigen::Vector2d overlap;          ///< component of d_x, d_y along value - mean
  Eigen::Vector2d gradient;         ///< means of d_x, d_y
  Eigen::Matrix2d inverse_hessian;  ///< of the sum of squares, in the shift
};

/// Builds the patch of `side` x `side` pixels around `centre` (pixels of this level, inside the
/// image). False if the patch has no corner: its rms gradient in the weakest direction is below
/// `min_gradient` [grey levels/px].
bool make_patch(const PyramidLevel& level, const Eigen::Vector2f& centre, const PatchShape& shape,
                int side, float min_gradient, Patch& patch);

/// Position of a patch in an image.
struct PatchPosition {
  Eigen::Vector2f centre;  ///< [px of the level]
  float correlation = 0;   ///< normalised, -1 to 1
};

/// Moves the patch from `start` to the best fit [px of the level], in at most `max_steps` steps,
/// until a step is below `precision` [px]. None if it leaves the image, or moves further than its
/// own side.
std::optional<PatchPosition> align(const Patch& patch, const PyramidLevel& level,
                                   const Eigen::Vector2f& start, int max_steps, float precision);

/// The normalised correlation of the patch with the image around `centre`, which must be inside it.
float correlation(const Patch& patch, const PyramidLevel& level, const Eigen::Vector2f& centre);

}  // namespace chasles
