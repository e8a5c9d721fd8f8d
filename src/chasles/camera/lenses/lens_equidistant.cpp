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

}  // namespace chasles::lens
