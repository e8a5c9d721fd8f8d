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

// With lambda < 0 the radius rises all the way to 180 degrees.
OptionalImage distort_bearing_division(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  const double lambda = k[0], z = bearing.z(), sine = bearing.head<2>().norm();
  if (sine < kNearAxis) return radial_bearing(bearing, 1, 1);
  const double inner = z * z - 4 * lambda * sine * sine;
  if (!(inner > 0) || (z <= 0 && lambda >= 0)) return std::nullopt;
  // Of two forms of the same root, that without cancellation.
  const double root = std::sqrt(inner);
  const double r = z > 0 ? 2 * sine / (z + root) : (z - root) / (2 * lambda * sine);
  const double bend = lambda * r * r;
  return radial_bearing(bearing, r / sine, (r * r + (1 + bend) * (1 + bend)) / (1 - bend));
}

OptionalBearing bearing_of_division(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double bend = k[0] * xy.squaredNorm();
  if (!(bend < 1) || !std::isfinite(bend)) return std::nullopt;
  return Eigen::Vector3d(xy.x(), xy.y(), 1 + bend).normalized();
}

LensDerivative by_coefficients_division(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  // By the implicit equation r z = sin theta (1 + lambda r^2).
  const double sine = bearing.head<2>().norm();
  LensDerivative d = LensDerivative::Zero(2, 1);
  const OptionalImage bent = distort_bearing_division(k, bearing);
  if (!bent || sine < kNearAxis) return d;
  const double r = bent->xy.norm();
  d.col(0) = r * r / (bearing.z() - 2 * k[0] * r * sine) * bearing.head<2>();
  return d;
}

}  // namespace chasles::lens
