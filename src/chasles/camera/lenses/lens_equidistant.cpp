#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {
namespace {

Polynomial<4> equidistant_polynomial(const LensCoefficients& k) { return {k[0], k[1], k[2], k[3]}; }

}  // namespace

OptionalPoint distort_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  return distort_angle(equidistant_polynomial(k), xy);
}

OptionalXy undistort_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  return undistort_angle(equidistant_polynomial(k), xy);
}

OptionalImage distort_bearing_equidistant(const LensCoefficients& k,
                                          const Eigen::Vector3d& bearing) {
  return distort_angle(equidistant_polynomial(k), bearing);
}

OptionalBearing bearing_of_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  return bearing_of_angle(equidistant_polynomial(k), xy);
}

LensDerivative by_coefficients_equidistant(const LensCoefficients& /*k*/,
                                           const Eigen::Vector3d& bearing) {
  return angle_by_coefficients<4>(bearing);
}

}  // namespace chasles::lens
