#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/rig_problem_detail.hpp>

/// Errors that corners have in common. Private to the calibrate folder.
namespace chasles::calibrate_detail {

/// Whether the corners of a view have moved since another one of the same camera: by a tenth of
/// their extent in the image, or no corner is in both.
bool has_moved(const TargetView& from, const TargetView& to);

/// To which piece of independent errors each instant belongs, from 0 on. Errors are alike in one
/// image, and in those that look the same: a new piece begins a second after the last one began,
/// but not before the target has moved in the images by a tenth of its size.
std::vector<int> independent_pieces(const std::vector<Instant>& instants);

/// By how much the variances of the unknowns `rows` are larger than those of independent errors.
/// `information`: of all unknowns of the border; `gradients`: of each instant (border x instants).
/// What each piece says of them scatters by that much more. One factor for all unknowns, because
/// each alone would have a noisy one. Fewer than ten pieces do not show it: then all instants of a
/// piece count as one. At least 1.
double correlation_factor(const Eigen::MatrixXd& information, const Eigen::MatrixXd& gradients,
                          std::span<const int> rows, std::span<const int> pieces);

}  // namespace chasles::calibrate_detail
