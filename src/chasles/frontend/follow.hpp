#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

namespace chasles {

/// Settings for following patches from image to image.
struct FollowSettings {
  int window = 15;                  ///< side of the patch on every level [px]
  double min_correlation = 0.8;     ///< on level 0
  double max_backward_error = 0.7;  ///< [px]
  double min_gradient = 1;          ///< in the weakest direction, on level 0 [grey levels/px]
};

using Bow = Eigen::Matrix<double, 2, 3>;

/// The pixel whose patch is followed, and its predicted position.
struct Expectation {
  Eigen::Vector2d from;                                     ///< in the first image [px]
  Eigen::Vector2d to;                                       ///< predicted in the second one [px]
  Eigen::Matrix2d to_A_from = Eigen::Matrix2d::Identity();  ///< d to / d from
  int levels = 1;                                           ///< of the pyramid, coarse to fine
  /// Second-order part of `from` as a function of `to`: bow (o_x^2, o_x o_y, o_y^2) [1/px].
  Bow from_bow_to = Bow::Zero();
};

enum class FollowOutcome { kFound, kFailed, kBackward };

/// Result of following a patch.
struct Followed {
  FollowOutcome outcome = FollowOutcome::kFailed;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the second image, if found
  double correlation = 0;
};

/// Follows the patch of `from` forward to the image `to`, and from there backward. The backward
/// result must agree with the start. The backward search starts as far from the solution as the
/// forward search did. Uses pyramidal Lucas & Kanade (Bouguet 2001), with the patch deformed by the
/// predicted to_A_from.
Followed follow(const ImagePyramid& from, const ImagePyramid& to, const Expectation& expected,
                const FollowSettings& settings);

/// The forward search only; none if it leaves the image or the correlation is too low.
std::optional<PatchPosition> follow_forth(const ImagePyramid& from, const ImagePyramid& to,
                                          const Expectation& expected,
                                          const FollowSettings& settings);

/// A patch found again, and its deformation.
struct Refound {
  Eigen::Vector2d pixel;      ///< in the second image [px]
  Eigen::Matrix2d to_A_from;  ///< d to / d from, estimated from the patches
};

/// Finds the patch of `from` near `expected.to`, on level 0 only, and refines its deformation by
/// one step (deformation()). None if it is not found, or if the step moves it by more than half a
/// pixel.
std::optional<Refound> find_again(const ImagePyramid& from, const ImagePyramid& to,
                                  const Expectation& expected, const FollowSettings& settings);

}  // namespace chasles
