#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {
namespace {

LensCoefficients omni_radtan(const LensCoefficients& k) { return {k[1], k[2], k[3], k[4]}; }

// Onto the plane of the mirror. Its radius rises up to 90 degrees for xi > -1.
OptionalPoint onto_mirror_plane(double xi, const Eigen::Vector2d& xy) {
  const double r = xy.norm();
  if (r < kNearAxis) return axis_point(xy, 1 / (1 + xi));
  const double d = std::sqrt(1 + r * r), bottom = 1 + xi * d;
  if (!(bottom > 0)) return std::nullopt;
  return radial_point(xy, r, 1 / bottom, (1 + xi / d) / (bottom * bottom));
}

}  // namespace

OptionalPoint distort_omni(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const OptionalPoint mirrored = onto_mirror_plane(k[0], xy);
  if (!mirrored) return std::nullopt;
  OptionalPoint bent = distort_radtan(omni_radtan(k), mirrored->xy);
  if (bent) bent->d_xy = bent->d_xy * mirrored->d_xy;
  return bent;
}

OptionalXy undistort_omni(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const OptionalXy mirrored = undistort_radtan(omni_radtan(k), xy);
  if (!mirrored) return std::nullopt;
  const double xi = k[0], r2 = mirrored->squaredNorm(), root = 1 + (1 - xi * xi) * r2;
  if (!(root >= 0)) return std::nullopt;
  const double along = (xi + std::sqrt(root)) / (1 + r2), depth = along - xi;
  if (!(depth > 0 && along > 0)) return std::nullopt;
  return along / depth * *mirrored;
}

bool omni_within(const LensCoefficients& k) { return k[0] > -1; }

double omni_slope(const LensCoefficients& k) { return 1 / (1 + k[0]); }

OptionalImage distort_bearing_omni(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  // Beyond 90 degrees its radius rises only where 1 + xi z is positive.
  const double bottom = bearing.z() + k[0], turn = 1 + k[0] * bearing.z();
  if (!(bottom > 0 && turn > 0)) return std::nullopt;
  const DistortedBearing mirrored = radial_bearing(bearing, 1 / bottom, turn / (bottom * bottom));
  const OptionalPoint bent = distort_radtan(omni_radtan(k), mirrored.xy);
  if (!bent) return std::nullopt;
  return DistortedBearing{.xy = bent->xy, .d_bearing = bent->d_xy * mirrored.d_bearing};
}

OptionalBearing bearing_of_omni(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const OptionalXy mirrored = undistort_radtan(omni_radtan(k), xy);
  if (!mirrored) return std::nullopt;
  const double xi = k[0], r2 = mirrored->squaredNorm(), root = 1 + (1 - xi * xi) * r2;
  if (!(root >= 0)) return std::nullopt;
  const double along = (xi + std::sqrt(root)) / (1 + r2);
  if (!(along > 0)) return std::nullopt;
  return Eigen::Vector3d(along * mirrored->x(), along * mirrored->y(), along - xi).normalized();
}

LensDerivative by_coefficients_omni(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  const double bottom = bearing.z() + k[0];
  const Eigen::Vector2d mirrored = bearing.head<2>() / bottom;
  const LensCoefficients radtan = omni_radtan(k);
  LensDerivative d(2, static_cast<Eigen::Index>(k.size()));
  d.col(0) = distort_radtan(radtan, mirrored)->d_xy * (-mirrored / bottom);
  d.rightCols(d.cols() - 1) = radtan_by_coefficients(radtan, mirrored).leftCols(d.cols() - 1);
  return d;
}

}  // namespace chasles::lens
