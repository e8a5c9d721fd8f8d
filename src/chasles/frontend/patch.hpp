#pragma once

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
/// The other image is J(p + o) = gain * T(o + p - p_true) + offset. The gradients are made
/// orthogonal to T and to 1 once. Gain and offset then drop out of the normal equations, and a step
/// needs three dot products of J with fixed patches.
struct Patch {
  static constexpr int kMaxSide = 23;
  static constexpr int kLanes = 24;  ///< floats in a row; those beyond the side have weight 0
  using Rows = float[kMaxSide * kLanes];

  int side = 0;                        ///< [px], odd
  alignas(16) float inside[kLanes];    ///< 1 up to the side, 0 beyond it
  alignas(16) Rows value;              ///< T, without its mean
  alignas(16) Rows d_x;                ///< dT/dx, orthogonal to T and 1
  alignas(16) Rows d_y;                ///< dT/dy, likewise
  float energy = 0;                    ///< sum of T squared
  float overlap_x = 0, overlap_y = 0;  ///< component of the plain dT/dx, dT/dy along T
  float mean_x = 0, mean_y = 0;        ///< of the plain dT/dx, dT/dy
  Eigen::Matrix2f inverse_hessian;     ///< of the sum of squares, in the shift
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
