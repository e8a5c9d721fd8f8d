#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include <chasles/camera/distortion.hpp>

namespace chasles {
namespace {

constexpr int kMaxIterations = 50;
// Of the residual, in units of the focal length: 1e-10 px for any lens.
constexpr double kConverged = 1e-14;

// Coefficients of a quartic: in powers of t, or in the Bernstein basis of an interval.
using Quartic = std::array<double, 5>;

// Whether a quartic in Bernstein form is positive on its whole interval. It lies in the convex hull
// of its coefficients. If that does not decide, the interval is halved (de Casteljau). A polynomial
// that is barely positive counts as not positive.
bool bernstein_positive(Quartic b, int halvings) {
  if (!(b.front() > 0 && b.back() > 0)) return false;
  if (std::ranges::all_of(b, [](double x) { return x > 0; })) return true;
  if (halvings == 0) return false;
  Quartic left{};
  for (std::size_t i = 0; i < b.size(); ++i) {
    left[i] = b[0];
    for (std::size_t j = 0; j + 1 < b.size() - i; ++j) b[j] = (b[j] + b[j + 1]) / 2;
  }
  return bernstein_positive(left, halvings - 1) && bernstein_positive(b, halvings - 1);
}

// Whether a[0] + a[1] t + ... + a[4] t^4 is positive on [0, end].
bool positive_up_to(const Quartic& a, double end) {
  const double c1 = a[1] * end;
  const double c2 = a[2] * end * end;
  const double c3 = a[3] * end * end * end;
  const double c4 = a[4] * end * end * end * end;
  return bernstein_positive({a[0], a[0] + c1 / 4, a[0] + c1 / 2 + c2 / 6,
                             a[0] + 3 * c1 / 4 + c2 / 2 + c3 / 4, a[0] + c1 + c2 + c3 + c4},
                            40);
}

// k1, k2, p1, p2, k3.
using Radtan = Eigen::Matrix<double, 5, 1>;

Radtan radtan_of(const Camera& camera) {
  Radtan c;
  c << camera.coefficients, camera.radtan_k3;
  return c;
}

std::optional<DistortedPoint> distort_radtan(const Radtan& c, const Eigen::Vector2d& xy) {
  const double x = xy.x();
  const double y = xy.y();
  const double r2 = xy.squaredNorm();
  if (!positive_up_to({1, 3 * c[0], 5 * c[1], 7 * c[4], 0}, r2)) return std::nullopt;
  const double scale = 1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]));
  DistortedPoint bent;
  bent.xy = scale * xy + Eigen::Vector2d(2 * c[2] * x * y + c[3] * (r2 + 2 * x * x),
                                         c[2] * (r2 + 2 * y * y) + 2 * c[3] * x * y);
  const double cross = 2 * (c[2] * x + c[3] * y);
  bent.d_xy = (2 * c[0] + r2 * (4 * c[1] + r2 * 6 * c[4])) * xy * xy.transpose();
  bent.d_xy(0, 0) += scale + 2 * c[2] * y + 6 * c[3] * x;
  bent.d_xy(1, 1) += scale + 6 * c[2] * y + 2 * c[3] * x;
  bent.d_xy(0, 1) += cross;
  bent.d_xy(1, 0) += cross;
  // The tangential terms may also fold the plane.
  if (!(bent.d_xy.determinant() > 0)) return std::nullopt;
  return bent;
}

// theta_d / theta and d theta_d / d theta of theta^2.
double equidistant_scale(const Eigen::Vector4d& c, double t) {
  return 1 + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3])));
}
double equidistant_slope(const Eigen::Vector4d& c, double t) {
  return 1 + t * (3 * c[0] + t * (5 * c[1] + t * (7 * c[2] + t * 9 * c[3])));
}
bool equidistant_rises(const Eigen::Vector4d& c, double theta) {
  return positive_up_to({1, 3 * c[0], 5 * c[1], 7 * c[2], 9 * c[3]}, theta * theta);
}

std::optional<DistortedPoint> distort_equidistant(const Eigen::Vector4d& c,
                                                  const Eigen::Vector2d& xy) {
  const double r = xy.norm();
  // The map is the identity up to terms in r^2.
  if (r < 1e-9) return DistortedPoint{.xy = xy, .d_xy = Eigen::Matrix2d::Identity()};
  const double theta = std::atan(r);
  if (!equidistant_rises(c, theta)) return std::nullopt;
  const double across = theta * equidistant_scale(c, theta * theta) / r;
  const double along = equidistant_slope(c, theta * theta) / (1 + r * r);
  const Eigen::Vector2d radial = xy / r;
  const Eigen::Vector2d tangential(-radial.y(), radial.x());
  DistortedPoint bent;
  bent.xy = across * xy;
  bent.d_xy = along * radial * radial.transpose() + across * tangential * tangential.transpose();
  return bent;
}

// Newton's method on the plane, starting from the axis. A step is halved until it stays before the
// fold and reduces the residual. The iteration ends when round-off prevents a reduction.
std::optional<Eigen::Vector2d> undistort_radtan(const Radtan& c, const Eigen::Vector2d& target) {
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();
  std::optional<DistortedPoint> bent = distort_radtan(c, xy);
  const double tolerance = kConverged * std::max(1.0, target.norm());
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d residual = target - bent->xy;
    Eigen::Vector2d step = bent->d_xy.inverse() * residual;
    std::optional<DistortedPoint> next = distort_radtan(c, xy + step);
    const auto helps = [&] {
      return next && (target - next->xy).squaredNorm() < residual.squaredNorm();
    };
    if (residual.norm() <= tolerance && !helps()) return xy;
    for (int halvings = 0; !helps(); ++halvings) {
      if (halvings == kMaxIterations) return std::nullopt;
      step /= 2;
      next = distort_radtan(c, xy + step);
    }
    xy += step;
    bent = next;
  }
  if ((target - bent->xy).norm() <= tolerance) return xy;
  return std::nullopt;
}

// Newton's method in theta, within the bracket given by the signs of the residual: theta_d rises up
// to the fold.
std::optional<Eigen::Vector2d> undistort_equidistant(const Eigen::Vector4d& c,
                                                     const Eigen::Vector2d& target) {
  const double theta_d = target.norm();
  if (theta_d < 1e-9) return target;
  double low = 0;
  double high = std::numbers::pi / 2;
  double theta = std::min(theta_d, (low + high) / 2);
  double moved = high;
  for (int i = 0; i < 2 * kMaxIterations && moved > 1e-16 * theta; ++i) {
    const double residual = theta_d - theta * equidistant_scale(c, theta * theta);
    const bool rises = equidistant_rises(c, theta);
    (rises && residual > 0 ? low : high) = theta;
    double next = theta + residual / equidistant_slope(c, theta * theta);
    if (!rises || !(next >= low && next <= high)) next = (low + high) / 2;
    moved = std::abs(next - theta);
    theta = next;
  }
  const double residual = theta_d - theta * equidistant_scale(c, theta * theta);
  if (!(std::abs(residual) <= kConverged && theta < std::numbers::pi / 2)) return std::nullopt;
  if (!equidistant_rises(c, theta)) return std::nullopt;
  return std::tan(theta) / theta_d * target;
}

}  // namespace

std::optional<DistortedPoint> distort(const Camera& camera, const Eigen::Vector2d& xy) {
  switch (camera.distortion) {
    case Distortion::kNone:
      return DistortedPoint{.xy = xy, .d_xy = Eigen::Matrix2d::Identity()};
    case Distortion::kRadtan:
      return distort_radtan(radtan_of(camera), xy);
    case Distortion::kEquidistant:
      return distort_equidistant(camera.coefficients, xy);
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& xy) {
  if (!xy.allFinite()) return std::nullopt;
  switch (camera.distortion) {
    case Distortion::kNone:
      return xy;
    case Distortion::kRadtan:
      return undistort_radtan(radtan_of(camera), xy);
    case Distortion::kEquidistant:
      return undistort_equidistant(camera.coefficients, xy);
  }
  return std::nullopt;
}

}  // namespace chasles
