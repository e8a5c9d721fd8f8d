#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/patch.hpp>

namespace chasles {

/// How patches are followed from image to image.
struct FollowSettings {
  int window = 15;                  ///< side of the patch on every level [px]
  double min_correlation = 0.8;     ///< on level 0
  double max_backward_error = 0.7;  ///< [px]
  double min_gradient = 1;          ///< in the weakest direction, on level 0 [grey levels/px]
};

/// The pixel whose patch is followed, and where it is expected.
struct Expectation {
  Eigen::Vector2d from;                                     ///< in the first image [px]
  Eigen::Vector2d to;                                       ///< expected in the second one [px]
  Eigen::Matrix2d to_A_from = Eigen::Matrix2d::Identity();  ///< d to / d from
  int levels = 1;                                           ///< of the pyramid, coarse to fine
};

enum class FollowOutcome { kFound, kFailed, kBackward };

/// What came of following a patch.
struct Followed {
  FollowOutcome outcome = FollowOutcome::kFailed;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the second image, if found
  double correlation = 0;
};

/// Finds the patch of `from` in the image `to`, and from there the way back, which must end where
/// it began; it starts as far from the truth as the way forth did. Lucas & Kanade with pyramids
/// (Bouguet 2001), the patch bent as expected.
Followed follow(const ImagePyramid& from, const ImagePyramid& to, const Expectation& expected,
                const FollowSettings& settings);

/// The way forth alone: none if it leaves the image or correlates badly.
std::optional<PatchPosition> follow_forth(const ImagePyramid& from, const ImagePyramid& to,
                                          const Expectation& expected,
                                          const FollowSettings& settings);

/// A patch found again, and how it is bent there.
struct Refound {
  Eigen::Vector2d pixel;      ///< in the second image [px]
  Eigen::Matrix2d to_A_from;  ///< d to / d from, as the patches tell
};

/// Where the patch of `from` lies near `expected.to`, on level 0 alone, and its bend improved by
/// one step (deformation()). None where it is not found, or the step moves it by more than half a
/// pixel.
std::optional<Refound> find_again(const ImagePyramid& from, const ImagePyramid& to,
                                  const Expectation& expected, const FollowSettings& settings);

}  // namespace chasles
