#pragma once

#include <utility>

#include "frame_steps.hpp"

// The reference for every form of a covariance (square_root_bench.cpp).
namespace chasles::bench {

using Oracle = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// Eight small random frames: landmarks and clones are added, observed, and every fifth is dropped.
Walk random_walk();

/// The covariance after the frames and the last frame's correction, by P - P H^T (H P H^T + R)^-1 H
/// P.
std::pair<Oracle, Oracle> textbook(const Walk& walk);

}  // namespace chasles::bench
