#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/target/saddle_points.hpp>

namespace chasles {

/// Where two edges cross, by a fit to the grey values.
struct RefinedCorner {
  Eigen::Vector2d pixel;
  double sigma = 0;  ///< standard deviation of each of its coordinates, by the residuals [px]
  double blur = 0;   ///< standard deviation of the edges' blur [px]
};

/// The crossing of two straight edges with one blur that fits the grey values around a saddle point
/// best (seven parameters; least squares by Levenberg and Marquardt). `radius` [px] is how far
/// nothing but these edges is. None where the image ends there, or the values have no such shape:
/// the corner leaves the middle of its surroundings, the blur fills them, or the residuals are a
/// large part of the contrast; and where the sigma would be above 0.15 px.
std::optional<RefinedCorner> refined_corner(const GreyPlane& image, const SaddlePoint& point,
                                            double radius);

}  // namespace chasles
