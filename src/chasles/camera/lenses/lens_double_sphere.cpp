#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {

// The first sphere shifts the ray by xi, which keeps the order of angles for xi > -1. The second is
// a unified camera, whose radius rises with the cosine of the shifted angle above
// -alpha / (1 - alpha) and above its inverse: the two conditions below. That cosine falls along a
// ray from the axis, so a point within them has no fold before it.
OptionalPoint distort_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double xi = k[0], alpha = k[1], r = xy.norm();
  if (r < kNearAxis) return axis_point(xy, double_sphere_slope(k));
  const double d1 = std::sqrt(1 + r * r), shifted = 1 + xi * d1, d2 = std::hypot(r, shifted);
  const double bottom = alpha * d2 + (1 - alpha) * shifted;
  const double rise = alpha * shifted / d2 + (1 - alpha);
  if (!(bottom > 0 && rise > 0)) return std::nullopt;
  return radial_point(xy, r, 1 / bottom, (1 + xi / d1) * rise / (bottom * bottom));
}

OptionalXy undistort_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double xi = k[0], alpha = k[1], r2 = xy.squaredNorm();
  const double root = 1 - (2 * alpha - 1) * r2;
  if (!(root >= 0)) return std::nullopt;
  const double bottom = alpha * std::sqrt(root) + 1 - alpha;
  if (!(bottom > 0)) return std::nullopt;
  const double z = (1 - alpha * alpha * r2) / bottom;
  const double inner = z * z + (1 - xi * xi) * r2;
  if (!(inner >= 0)) return std::nullopt;
  const double along = (z * xi + std::sqrt(inner)) / (z * z + r2), depth = along * z - xi;
  if (!(depth > 0 && along > 0)) return std::nullopt;
  return along / depth * xy;
}

bool double_sphere_within(const LensCoefficients& k) { return k[0] > -1 && k[1] >= 0 && k[1] <= 1; }

double double_sphere_slope(const LensCoefficients& k) { return 1 / (1 + k[0]); }

// Beyond 90 degrees the first sphere folds for xi > 1, where 1 + xi z is zero.
OptionalImage distort_bearing_double_sphere(const LensCoefficients& k,
                                            const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  const double xi = k[0], alpha = k[1], shifted = bearing.z() + xi;
  const double d = std::hypot(bearing.head<2>().norm(), shifted);
  const double bottom = alpha * d + (1 - alpha) * shifted;
  const double rise = alpha * shifted / d + (1 - alpha), turn = 1 + xi * bearing.z();
  if (!(bottom > 0 && rise > 0 && turn > 0)) return std::nullopt;
  return radial_bearing(bearing, 1 / bottom, turn * rise / (bottom * bottom));
}

OptionalBearing bearing_of_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double xi = k[0], alpha = k[1], r2 = xy.squaredNorm();
  const double root = 1 - (2 * alpha - 1) * r2;
  if (!(root >= 0)) return std::nullopt;
  const double bottom = alpha * std::sqrt(root) + 1 - alpha;
  if (!(bottom > 0)) return std::nullopt;
  const double z = (1 - alpha * alpha * r2) / bottom;
  const double inner = z * z + (1 - xi * xi) * r2;
  if (!(inner >= 0)) return std::nullopt;
  const double along = (z * xi + std::sqrt(inner)) / (z * z + r2);
  if (!(along > 0)) return std::nullopt;
  return Eigen::Vector3d(along * xy.x(), along * xy.y(), along * z - xi).normalized();
}

LensDerivative by_coefficients_double_sphere(const LensCoefficients& k,
                                             const Eigen::Vector3d& bearing) {
  const double alpha = k[1], shifted = bearing.z() + k[0];
  const double d = std::hypot(bearing.head<2>().norm(), shifted);
  const double bottom = alpha * d + (1 - alpha) * shifted;
  const Eigen::RowVector2d d_bottom(alpha * shifted / d + (1 - alpha), d - shifted);
  return -bearing.head<2>() / (bottom * bottom) * d_bottom;
}

}  // namespace chasles::lens
