#include <chasles/camera/lenses/lens_detail.hpp>

namespace chasles::lens {
namespace {

constexpr std::size_t kPolynomialLens = 5;  // coefficients of the model without further terms

// The radial factor, and its derivative by t = r^2 twice.
struct RadialFactor {
  double scale = 1, twice_slope = 0;
};

// None where the radius falls, or where the denominator is not positive, up to t.
std::optional<RadialFactor> rational_factor(const LensCoefficients& k, double t) {
  const Polynomial<4> n{1, k[0], k[1], k[4]}, d{1, k[5], k[6], k[7]};
  if (!positive_up_to(d, t)) return std::nullopt;
  // d r_d / d r, times the square of the denominator: (n + 2 t n') d - 2 t n d'.
  Polynomial<7> rise{};
  for (std::size_t i = 0; i < n.size(); ++i) {
    for (std::size_t j = 0; j < d.size(); ++j) {
      rise[i + j] += (1 + 2 * static_cast<double>(i) - 2 * static_cast<double>(j)) * n[i] * d[j];
    }
  }
  if (!positive_up_to(rise, t)) return std::nullopt;
  const double top = 1 + t * (k[0] + t * (k[1] + t * k[4]));
  const double bottom = 1 + t * (k[5] + t * (k[6] + t * k[7]));
  const double d_top = k[0] + t * (2 * k[1] + t * 3 * k[4]);
  const double d_bottom = k[5] + t * (2 * k[6] + t * 3 * k[7]);
  return RadialFactor{.scale = top / bottom,
                      .twice_slope = 2 * (d_top * bottom - top * d_bottom) / (bottom * bottom)};
}

std::optional<RadialFactor> polynomial_factor(const LensCoefficients& k, double r2) {
  if (!positive_up_to(Polynomial<5>{1, 3 * k[0], 5 * k[1], 7 * k[4], 0}, r2)) return std::nullopt;
  return RadialFactor{.scale = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])),
                      .twice_slope = 2 * k[0] + r2 * (4 * k[1] + r2 * 6 * k[4])};
}

void add_prism(const LensCoefficients& k, double r2, const Eigen::Vector2d& xy,
               DistortedPoint& bent) {
  const Eigen::Vector2d s(k[8], k[10]), s2(k[9], k[11]);
  bent.xy += r2 * s + r2 * r2 * s2;
  bent.d_xy += (2 * s + 4 * r2 * s2) * xy.transpose();
}

}  // namespace

OptionalPoint distort_radtan(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double x = xy.x();
  const double y = xy.y();
  const double r2 = xy.squaredNorm();
  const bool further = k.size() > kPolynomialLens;
  const auto factor = further ? rational_factor(k, r2) : polynomial_factor(k, r2);
  if (!factor) return std::nullopt;
  const double scale = factor->scale;
  DistortedPoint bent;
  bent.xy = scale * xy + Eigen::Vector2d(2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
                                         k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y);
  const double cross = 2 * (k[2] * x + k[3] * y);
  bent.d_xy = factor->twice_slope * xy * xy.transpose();
  bent.d_xy(0, 0) += scale + 2 * k[2] * y + 6 * k[3] * x;
  bent.d_xy(1, 1) += scale + 6 * k[2] * y + 2 * k[3] * x;
  bent.d_xy(0, 1) += cross;
  bent.d_xy(1, 0) += cross;
  if (further) add_prism(k, r2, xy, bent);
  // The tangential terms may also fold the plane.
  if (!(bent.d_xy.determinant() > 0)) return std::nullopt;
  return bent;
}

OptionalXy undistort_radtan(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  return solve_on_plane([&](const Eigen::Vector2d& from) { return distort_radtan(k, from); }, xy);
}

LensDerivative radtan_by_coefficients(const LensCoefficients& k, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), t = xy.squaredNorm();
  const double top = 1 + t * (k[0] + t * (k[1] + t * k[4]));
  const double bottom = 1 + t * (k[5] + t * (k[6] + t * k[7]));
  const double falls = -top / (bottom * bottom);
  Eigen::Matrix<double, 2, LensCoefficients::kMost> d;
  d << x * t / bottom, x * t * t / bottom, 2 * x * y, t + 2 * x * x, x * t * t * t / bottom,
      falls * x * t, falls * x * t * t, falls * x * t * t * t, t, t * t, 0, 0,  //
      y * t / bottom, y * t * t / bottom, t + 2 * y * y, 2 * x * y, y * t * t * t / bottom,
      falls * y * t, falls * y * t * t, falls * y * t * t * t, 0, 0, t, t * t;
  return d.leftCols(static_cast<Eigen::Index>(k.size()));
}

LensDerivative by_coefficients_radtan(const LensCoefficients& k, const Eigen::Vector3d& bearing) {
  return radtan_by_coefficients(k, on_plane(bearing));
}

}  // namespace chasles::lens
