#pragma once

#include <chasles/initialise/dynamic_window.hpp>

namespace chasles {

/// The gyroscope bias [rad/s] for which the rays of the tracks agree with a rotation between
/// keyframes, for any translation (idea: Kneip & Lynen 2013; here one bias connects all pairs).
/// With u = R(bias) ray, the normals n = u_i x u_j of a pair of keyframes lie in one plane. The
/// normal of this plane is the direction t of the translation. The estimate minimises the sum of (t
/// . n)^2, each in its own standard deviations, over the bias and each pair's t. To exclude wrong
/// tracks, each pair's t comes from the two normals with the least truncated sum; the truncation
/// shrinks with the uncertainty of the bias. Deterministic. Where the tracks do not determine the
/// bias, it stays near 0 (prior_sigma [rad/s]).
Eigen::Vector3d gyroscope_bias(const MotionWindow& window, double prior_sigma);

/// Removes views that, at this bias, are off the epipolar line of most keyframes that they are
/// compared with. Removes tracks that have fewer than three keyframes left.
void drop_mismatched(MotionWindow& window, const Eigen::Vector3d& bias);

}  // namespace chasles
