#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {

OptionalPoint distort_fov(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double w = k[0], stretch = 2 * std::tan(w / 2), r = xy.norm();
  if (r < kNearAxis) return axis_point(xy, fov_slope(k));
  const double stretched = stretch * r;
  return radial_point(xy, r, std::atan(stretched) / (w * r),
                      stretch / (w * (1 + stretched * stretched)));
}

OptionalXy undistort_fov(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double w = k[0], stretch = 2 * std::tan(w / 2), r_d = xy.norm();
  if (r_d < kNearAxis) return xy / fov_slope(k);
  if (!(r_d * w < std::numbers::pi / 2)) return std::nullopt;
  return std::tan(r_d * w) / (stretch * r_d) * xy;
}

bool fov_within(const LensCoefficients& k) { return k[0] > 0 && k[0] < std::numbers::pi; }

double fov_slope(const LensCoefficients& k) { return 2 * std::tan(k[0] / 2) / k[0]; }

OptionalImage distort_bearing_fov(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  const double w = k[0], stretch = 2 * std::tan(w / 2), z = bearing.z();
  const double sine = bearing.head<2>().norm(), stretched = stretch * sine;
  if (sine < kNearAxis) return radial_bearing(bearing, fov_slope(k), fov_slope(k));
  return radial_bearing(bearing, std::atan2(stretched, z) / (w * sine),
                        stretch / (w * (z * z + stretched * stretched)));
}

OptionalBearing bearing_of_fov(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double w = k[0], stretch = 2 * std::tan(w / 2), r_d = xy.norm(), angle = r_d * w;
  if (r_d < kNearAxis) {
    return Eigen::Vector3d(xy.x() / fov_slope(k), xy.y() / fov_slope(k), 1);
  }
  if (!(angle < std::numbers::pi)) return std::nullopt;
  const double across = std::sin(angle) / (stretch * r_d);
  return Eigen::Vector3d(across * xy.x(), across * xy.y(), std::cos(angle)).normalized();
}

LensDerivative by_coefficients_fov(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  const double w = k[0], stretch = 2 * std::tan(w / 2), z = bearing.z();
  const double sine = bearing.head<2>().norm(), stretched = stretch * sine;
  const double d_stretch = 1 + stretch * stretch / 4;
  LensDerivative d(2, 1);
  if (sine < kNearAxis) {
    d.col(0) = (d_stretch - stretch / w) / w * bearing.head<2>();
    return d;
  }
  const double d_angle = z * sine * d_stretch / (z * z + stretched * stretched);
  d.col(0) = (d_angle - std::atan2(stretched, z) / w) / (w * sine) * bearing.head<2>();
  return d;
}

}  // namespace chasles::lens
