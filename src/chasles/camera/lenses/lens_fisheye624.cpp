#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {
namespace {

Polynomial<6> fisheye624_polynomial(const LensCoefficients& k) {
  return {k[0], k[1], k[2], k[3], k[4], k[5]};
}

// The tangential and prism terms, which may fold the plane.
OptionalPoint shift_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& q) {
  const Eigen::Vector2d p(k[6], k[7]), s(k[8], k[10]), s2(k[9], k[11]);
  const double r2 = q.squaredNorm(), across = 2 * q.dot(p);
  DistortedPoint bent;
  bent.xy = q + r2 * p + across * q + r2 * s + r2 * r2 * s2;
  bent.d_xy = (1 + across) * Eigen::Matrix2d::Identity() + 2 * q * p.transpose() +
              (2 * p + 2 * s + 4 * r2 * s2) * q.transpose();
  if (!(bent.d_xy.determinant() > 0)) return std::nullopt;
  return bent;
}

}  // namespace

OptionalPoint distort_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const OptionalPoint radial = distort_angle(fisheye624_polynomial(k), xy);
  if (!radial) return std::nullopt;
  OptionalPoint bent = shift_fisheye624(k, radial->xy);
  if (bent) bent->d_xy = bent->d_xy * radial->d_xy;
  return bent;
}

OptionalXy undistort_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const auto shift = [&](const Eigen::Vector2d& q) { return shift_fisheye624(k, q); };
  const OptionalXy radial = solve_on_plane(shift, xy);
  if (!radial) return std::nullopt;
  return undistort_angle(fisheye624_polynomial(k), *radial);
}

OptionalImage distort_bearing_fisheye624(const LensCoefficients& k,
                                         const Eigen::Vector3d& bearing) {
  const OptionalImage radial = distort_angle(fisheye624_polynomial(k), bearing);
  if (!radial) return std::nullopt;
  const OptionalPoint bent = shift_fisheye624(k, radial->xy);
  if (!bent) return std::nullopt;
  return DistortedBearing{.xy = bent->xy, .d_bearing = bent->d_xy * radial->d_bearing};
}

OptionalBearing bearing_of_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const auto shift = [&](const Eigen::Vector2d& q) { return shift_fisheye624(k, q); };
  const OptionalXy radial = solve_on_plane(shift, xy);
  if (!radial) return std::nullopt;
  return bearing_of_angle(fisheye624_polynomial(k), *radial);
}

LensDerivative by_coefficients_fisheye624(const LensCoefficients& k,
                                          const Eigen::Vector3d& bearing) {
  const Eigen::Vector2d q = distort_angle(fisheye624_polynomial(k), bearing)->xy;
  const double x = q.x(), y = q.y(), t = q.squaredNorm();
  LensDerivative d(2, 12);
  d.leftCols<6>() = shift_fisheye624(k, q)->d_xy * angle_by_coefficients<6>(bearing);
  d.rightCols<6>() << t + 2 * x * x, 2 * x * y, t, t * t, 0, 0,  //
      2 * x * y, t + 2 * y * y, 0, 0, t, t * t;
  return d;
}

}  // namespace chasles::lens
