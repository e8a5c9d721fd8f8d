#pragma once

#include <chasles/slam/dynamic_window.hpp>

namespace chasles {

/// The gyroscope's bias that makes the rays of the tracks agree with rotation between keyframes,
/// whatever the translation: with u = R(bias) ray, the normals n = u_i x u_j of a pair of keyframes
/// lie in one plane, whose normal is the direction t of the translation. The sum of (t . n)^2, each
/// in its own standard deviations, is least over the bias and each pair's t (Kneip & Lynen 2013,
/// for the idea; the gyroscope joins all pairs by one bias). Wrong tracks: each pair's t is that of
/// two normals with the least truncated sum, at a truncation that shrinks with the bias's
/// uncertainty; deterministic. Where the tracks do not tell, it stays near 0 (prior_sigma, rad/s).
Eigen::Vector3d gyroscope_bias(const MotionWindow& window, double prior_sigma);

/// Takes views out that do not lie on the epipolar line, at that bias, of most keyframes that they
/// are compared with, and tracks that have less than three keyframes left.
void drop_mismatched(MotionWindow& window, const Eigen::Vector3d& bias);

}  // namespace chasles
