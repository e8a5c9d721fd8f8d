#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {

// Its radius rises up to 90 degrees with all coefficients within the limits.
OptionalPoint distort_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double alpha = k[0], beta = k[1], r = xy.norm();
  if (r < kNearAxis) return axis_point(xy, 1);
  const double d = std::sqrt(beta * r * r + 1), bottom = alpha * d + 1 - alpha;
  const double rise = alpha / d + 1 - alpha;
  if (!(bottom > 0 && rise > 0)) return std::nullopt;
  return radial_point(xy, r, 1 / bottom, rise / (bottom * bottom));
}

OptionalXy undistort_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double alpha = k[0], t = k[1] * xy.squaredNorm();
  const double root = 1 - (2 * alpha - 1) * t;
  if (!(root >= 0)) return std::nullopt;
  const double depth = (1 - alpha * alpha * t) / (alpha * std::sqrt(root) + 1 - alpha);
  if (!(depth > 0)) return std::nullopt;
  return xy / depth;
}

bool eucm_within(const LensCoefficients& k) { return k[0] >= 0 && k[0] <= 1 && k[1] > 0; }

}  // namespace chasles::lens
