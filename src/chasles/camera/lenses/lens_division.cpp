#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {

OptionalPoint distort_division(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double r = xy.norm(), inner = 1 - 4 * k[0] * r * r;
  if (r < kNearAxis) return axis_point(xy, 1);
  if (!(inner > 0)) return std::nullopt;
  // r_d / r = 1 + lambda r_d^2, and the slope of r_d is its square over 1 - lambda r_d^2.
  const double root = std::sqrt(inner), across = 2 / (1 + root);
  return radial_point(xy, r, across, across * across * (1 + root) / (2 * root));
}

OptionalXy undistort_division(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double bend = k[0] * xy.squaredNorm();
  if (!(std::abs(bend) < 1)) return std::nullopt;
  return xy / (1 + bend);
}

}  // namespace chasles::lens
