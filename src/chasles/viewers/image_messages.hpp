#pragma once

#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/shown_images.hpp>
#include <chasles/viewers/channels.hpp>

namespace chasles {

/// foxglove.CompressedImage of a kept image; null where it has no picture.
nlohmann::json image_message(const ShownImage& image);

/// foxglove.ImageAnnotations of a kept image, in the picture's own pixels: a mark for each point by
/// its outcome (circle: used, cross: rejected, square: begun, dot: waiting), a line to its position
/// some frames before, and the 3 sigma ellipse about its predicted position.
nlohmann::json annotations_message(const ShownImage& image);

/// Adds /camN/image and /camN/annotations.
void add_images(const std::vector<ShownImage>& images, Channels& out);

/// The corners of a polygon on the ellipse of that many sigmas about a point; empty if the
/// covariance is not positive definite.
std::vector<Eigen::Vector2d> ellipse_points(const ExpectedPixel& expected, double sigmas);

}  // namespace chasles
