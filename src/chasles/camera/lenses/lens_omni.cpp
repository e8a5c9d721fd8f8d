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

}  // namespace chasles::lens
