#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/data/run_images.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// Adds the kept images on /camN/image, and annotations on /camN/annotations in the pictures' own
/// pixels: a mark for each point by its outcome (circle: used, cross: rejected, square: begun, dot:
/// waiting), a line to its position some frames before, and the 3 sigma ellipse about its predicted
/// position.
void add_images(const std::vector<RunImage>& images, Channels& out);

/// The corners of a polygon on the ellipse of that many sigmas about a point; empty if the
/// covariance is not positive definite.
std::vector<Eigen::Vector2d> ellipse_points(const ExpectedPixel& expected, double sigmas);

}  // namespace chasles
