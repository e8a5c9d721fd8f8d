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

OptionalImage distort_bearing_eucm(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  const double alpha = k[0], z = bearing.z();
  const double d = std::sqrt(k[1] * bearing.head<2>().squaredNorm() + z * z);
  const double bottom = alpha * d + (1 - alpha) * z, rise = alpha * z / d + 1 - alpha;
  if (!(bottom > 0 && rise > 0)) return std::nullopt;
  return radial_bearing(bearing, 1 / bottom, rise / (bottom * bottom));
}

OptionalBearing bearing_of_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double alpha = k[0], t = k[1] * xy.squaredNorm();
  const double root = 1 - (2 * alpha - 1) * t;
  if (!(root >= 0)) return std::nullopt;
  const double bottom = alpha * std::sqrt(root) + 1 - alpha;
  if (!(bottom > 0)) return std::nullopt;
  return Eigen::Vector3d(xy.x(), xy.y(), (1 - alpha * alpha * t) / bottom).normalized();
}

LensDerivative by_coefficients_eucm(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  const double alpha = k[0], z = bearing.z(), r2 = bearing.head<2>().squaredNorm();
  const double d = std::sqrt(k[1] * r2 + z * z), bottom = alpha * d + (1 - alpha) * z;
  const Eigen::RowVector2d d_bottom(d - z, alpha * r2 / (2 * d));
  return -bearing.head<2>() / (bottom * bottom) * d_bottom;
}

}  // namespace chasles::lens
