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

}  // namespace chasles::lens
