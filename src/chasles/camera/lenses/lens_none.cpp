#include <chasles/camera/lenses/lens_model.hpp>

namespace chasles::lens {

OptionalPoint distort_none(const LensCoefficients& /*k*/, const Eigen::Vector2d& xy) {
  return DistortedPoint{.xy = xy, .d_xy = Eigen::Matrix2d::Identity()};
}

OptionalXy undistort_none(const LensCoefficients& /*k*/, const Eigen::Vector2d& xy) { return xy; }

LensDerivative by_coefficients_none(const LensCoefficients& /*k*/,
                                    const Eigen::Vector3d& /*bearing*/) {
  return LensDerivative(2, 0);
}

}  // namespace chasles::lens
