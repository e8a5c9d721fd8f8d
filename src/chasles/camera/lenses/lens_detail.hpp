#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include <Eigen/Core>
#include <Eigen/LU>

#include <chasles/camera/lenses/lens_model.hpp>

// What several lens models share. Included by their sources only.
namespace chasles::lens {

inline constexpr int kMaxIterations = 50;
// Of the residual, in units of the focal length: 1e-10 px for any lens.
inline constexpr double kConverged = 1e-14;

/// A polynomial: coefficients in powers of t, or in the Bernstein basis of an interval.
template <std::size_t N>
using Polynomial = std::array<double, N>;

/// Whether a polynomial in Bernstein form is positive on its whole interval. It lies in the convex
/// hull of its coefficients. If that does not decide, the interval is halved (de Casteljau). A
/// polynomial that is barely positive counts as not positive.
template <std::size_t N>
bool bernstein_positive(Polynomial<N> b, int halvings) {
  if (!(b.front() > 0 && b.back() > 0)) return false;
  if (std::ranges::all_of(b, [](double x) { return x > 0; })) return true;
  if (halvings == 0) return false;
  Polynomial<N> left{};
  for (std::size_t i = 0; i < b.size(); ++i) {
    left[i] = b[0];
    for (std::size_t j = 0; j + 1 < b.size() - i; ++j) b[j] = (b[j] + b[j + 1]) / 2;
  }
  return bernstein_positive(left, halvings - 1) && bernstein_positive(b, halvings - 1);
}

/// Whether a[0] + a[1] t + ... is positive on [0, end].
template <std::size_t N>
bool positive_up_to(const Polynomial<N>& a, double end) {
  Polynomial<N> b{};
  double power = 1;
  for (std::size_t j = 0; j < N; ++j) {
    // C(i, j) / C(N - 1, j), for all i.
    double ratio = 1;
    for (std::size_t i = N; i-- > j;) {
      b[i] += ratio * a[j] * power;
      if (i > 0) ratio *= static_cast<double>(i - j) / static_cast<double>(i);
    }
    power *= end;
  }
  return bernstein_positive(b, 40);
}

/// The same for a quartic, which every pixel of the common lenses needs.
inline bool positive_up_to(const Polynomial<5>& a, double end) {
  const double c1 = a[1] * end;
  const double c2 = a[2] * end * end;
  const double c3 = a[3] * end * end * end;
  const double c4 = a[4] * end * end * end * end;
  return bernstein_positive(
      Polynomial<5>{a[0], a[0] + c1 / 4, a[0] + c1 / 2 + c2 / 6,
                    a[0] + 3 * c1 / 4 + c2 / 2 + c3 / 4, a[0] + c1 + c2 + c3 + c4},
      40);
}

/// The point of a map that only moves points along the ray from the axis: its factor `across`, and
/// its slope `along`. r = |xy| is not zero.
inline DistortedPoint radial_point(const Eigen::Vector2d& xy, double r, double across,
                                   double along) {
  const Eigen::Vector2d radial = xy / r;
  const Eigen::Vector2d tangential(-radial.y(), radial.x());
  DistortedPoint bent;
  bent.xy = across * xy;
  bent.d_xy = along * radial * radial.transpose() + across * tangential * tangential.transpose();
  return bent;
}

/// Nearer to the axis than this, a map is its derivative there to round-off: it has no even powers.
inline constexpr double kNearAxis = 1e-9;

/// The point at the axis of a map with this slope there.
inline DistortedPoint axis_point(const Eigen::Vector2d& xy, double slope) {
  return {.xy = slope * xy, .d_xy = slope * Eigen::Matrix2d::Identity()};
}

/// The image of a unit bearing by such a map of the angle theta from the axis: the radius over sin
/// theta, and the slope of the radius by theta. The bearing is not straight behind.
inline DistortedBearing radial_bearing(const Eigen::Vector3d& bearing, double across,
                                       double slope) {
  const double sine = bearing.head<2>().norm();
  DistortedBearing bent;
  bent.xy = across * bearing.head<2>();
  if (sine < kNearAxis) {
    bent.d_bearing << across * Eigen::Matrix2d::Identity(), -bent.xy;
    return bent;
  }
  const Eigen::Vector2d radial = bearing.head<2>() / sine;
  const Eigen::Vector2d tangential(-radial.y(), radial.x());
  bent.d_bearing << slope * bearing.z() * radial * radial.transpose() +
                        across * tangential * tangential.transpose(),
      -slope * sine * radial;
  return bent;
}

/// Whether a unit vector is finite and not straight behind the camera.
inline bool may_have_image(const Eigen::Vector3d& bearing) {
  return bearing.allFinite() && (bearing.z() > 0 || bearing.head<2>().norm() >= kNearAxis);
}

/// (x/z, y/z), of models that end before 90 degrees.
inline Eigen::Vector2d on_plane(const Eigen::Vector3d& bearing) {
  return bearing.head<2>() / bearing.z();
}

/// The derivatives of radtan at (x/z, y/z), which omni has, too.
LensDerivative radtan_by_coefficients(const LensCoefficients& k, const Eigen::Vector2d& xy);

/// Newton's method on the plane, starting from the axis. A step is halved until it stays before the
/// fold and reduces the residual. The iteration ends when round-off prevents a reduction.
template <typename Distort>
std::optional<Eigen::Vector2d> solve_on_plane(const Distort& distort,
                                              const Eigen::Vector2d& target) {
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();
  std::optional<DistortedPoint> bent = distort(xy);
  const double tolerance = kConverged * std::max(1.0, target.norm());
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d residual = target - bent->xy;
    Eigen::Vector2d step = bent->d_xy.inverse() * residual;
    std::optional<DistortedPoint> next = distort(xy + step);
    const auto helps = [&] {
      return next && (target - next->xy).squaredNorm() < residual.squaredNorm();
    };
    if (residual.norm() <= tolerance && !helps()) return xy;
    for (int halvings = 0; !helps(); ++halvings) {
      if (halvings == kMaxIterations) return std::nullopt;
      step /= 2;
      next = distort(xy + step);
    }
    xy += step;
    bent = next;
  }
  if ((target - bent->xy).norm() <= tolerance) return xy;
  return std::nullopt;
}

/// theta_d / theta of theta^2 = t, and d theta_d / d theta, with
/// theta_d = theta (1 + c[0] theta^2 + c[1] theta^4 + ...).
template <std::size_t N>
double angle_scale(const Polynomial<N>& c, double t) {
  double sum = t * c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = t * (c[i] + sum);
  return 1 + sum;
}
template <std::size_t N>
double angle_slope(const Polynomial<N>& c, double t) {
  double sum = t * static_cast<double>(2 * N + 1) * c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = t * (static_cast<double>(2 * i + 3) * c[i] + sum);
  return 1 + sum;
}
template <std::size_t N>
bool angle_rises(const Polynomial<N>& c, double theta) {
  Polynomial<N + 1> slope{1};
  for (std::size_t i = 0; i < N; ++i) slope[i + 1] = static_cast<double>(2 * i + 3) * c[i];
  return positive_up_to(slope, theta * theta);
}

/// x theta_d / r.
template <std::size_t N>
std::optional<DistortedPoint> distort_angle(const Polynomial<N>& c, const Eigen::Vector2d& xy) {
  const double r = xy.norm();
  if (r < kNearAxis) return DistortedPoint{.xy = xy, .d_xy = Eigen::Matrix2d::Identity()};
  const double theta = std::atan(r);
  if (!angle_rises(c, theta)) return std::nullopt;
  const double across = theta * angle_scale(c, theta * theta) / r;
  const double along = angle_slope(c, theta * theta) / (1 + r * r);
  return radial_point(xy, r, across, along);
}

/// Its inverse, an angle below `high`. Newton's method in theta, within the bracket given by the
/// signs of the residual: theta_d rises up to the fold.
template <std::size_t N>
std::optional<double> solve_angle(const Polynomial<N>& c, double theta_d, double high) {
  const double end = high, tolerance = kConverged * std::max(1.0, theta_d);
  double low = 0;
  double theta = std::min(theta_d, (low + high) / 2);
  double moved = high;
  for (int i = 0; i < 2 * kMaxIterations && moved > 1e-16 * theta; ++i) {
    const double residual = theta_d - theta * angle_scale(c, theta * theta);
    const bool rises = angle_rises(c, theta);
    (rises && residual > 0 ? low : high) = theta;
    double next = theta + residual / angle_slope(c, theta * theta);
    if (!rises || !(next >= low && next <= high)) next = (low + high) / 2;
    moved = std::abs(next - theta);
    theta = next;
  }
  const double residual = theta_d - theta * angle_scale(c, theta * theta);
  if (!(std::abs(residual) <= tolerance && theta < end)) return std::nullopt;
  if (!angle_rises(c, theta)) return std::nullopt;
  return theta;
}

template <std::size_t N>
std::optional<Eigen::Vector2d> undistort_angle(const Polynomial<N>& c,
                                               const Eigen::Vector2d& target) {
  const double theta_d = target.norm();
  if (theta_d < kNearAxis) return target;
  const auto theta = solve_angle(c, theta_d, std::numbers::pi / 2);
  if (!theta) return std::nullopt;
  return std::tan(*theta) / theta_d * target;
}

/// The same two maps for unit bearings.
template <std::size_t N>
std::optional<DistortedBearing> distort_angle(const Polynomial<N>& c,
                                              const Eigen::Vector3d& bearing) {
  if (!may_have_image(bearing)) return std::nullopt;
  const double sine = bearing.head<2>().norm();
  if (sine < kNearAxis) return radial_bearing(bearing, 1, 1);
  const double theta = std::atan2(sine, bearing.z());
  if (!angle_rises(c, theta)) return std::nullopt;
  return radial_bearing(bearing, theta * angle_scale(c, theta * theta) / sine,
                        angle_slope(c, theta * theta));
}

template <std::size_t N>
std::optional<Eigen::Vector3d> bearing_of_angle(const Polynomial<N>& c,
                                                const Eigen::Vector2d& target) {
  const double theta_d = target.norm();
  if (theta_d < kNearAxis) return Eigen::Vector3d(target.x(), target.y(), 1);
  const auto theta = solve_angle(c, theta_d, std::numbers::pi);
  if (!theta) return std::nullopt;
  const double across = std::sin(*theta) / theta_d;
  return Eigen::Vector3d(across * target.x(), across * target.y(), std::cos(*theta));
}

/// d theta_d / d c: the powers of theta, in the direction of the bearing.
template <std::size_t N>
LensDerivative angle_by_coefficients(const Eigen::Vector3d& bearing) {
  LensDerivative d = LensDerivative::Zero(2, static_cast<Eigen::Index>(N));
  const double sine = bearing.head<2>().norm();
  if (sine < kNearAxis) return d;
  const double theta = std::atan2(sine, bearing.z());
  double power = theta;
  for (Eigen::Index i = 0; i < d.cols(); ++i) {
    power *= theta * theta;
    d.col(i) = power / sine * bearing.head<2>();
  }
  return d;
}

}  // namespace chasles::lens
