#include <cmath>

#include <Eigen/Geometry>

#include <chasles/lie/so3.hpp>

namespace chasles {

Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

namespace so3 {
namespace {

// The coefficients below are s_n(t) = sum over k of (-t^2)^k / (2k+n)!. Their closed forms suffer
// from cancellation at small angles: (t - sin t)/t^3 loses 8 digits at t = 1e-3. Below the limit
// the 11 terms reach round-off (the next one is at most 2e-16 of the sum). Above it the closed
// forms lose at most one digit.
constexpr double kSeriesBelow = 2.0;

constexpr double kNearlyOpposite = -0.99;  // cosine of two directions

double series(double t2, int n) {
  double term = 1.0;
  for (int i = 2; i <= n; ++i) term /= i;
  double sum = term;
  for (int k = 1; k <= 10; ++k) {
    term *= -t2 / ((2 * k + n - 1) * (2 * k + n));
    sum += term;
  }
  return sum;
}

double s1(double t) { return t < kSeriesBelow ? series(t * t, 1) : std::sin(t) / t; }
double s2(double t) { return t < kSeriesBelow ? series(t * t, 2) : (1 - std::cos(t)) / (t * t); }
double s3(double t) {
  return t < kSeriesBelow ? series(t * t, 3) : (t - std::sin(t)) / (t * t * t);
}
double s4(double t) {
  return t < kSeriesBelow ? series(t * t, 4) : (std::cos(t) - 1 + t * t / 2) / (t * t * t * t);
}
double s5(double t) {
  return t < kSeriesBelow ? series(t * t, 5)
                          : (std::sin(t) - t + t * t * t / 6) / (t * t * t * t * t);
}

// 1/t^2 - cot(t/2)/(2t): the coefficient of hat^2 in the inverse Jacobian.
double inverse_coefficient(double t) {
  if (t < 0.5) {
    // Bernoulli numbers: |B_2k| t^(2k-2) / (2k)!
    const double x = t * t;
    return 1. / 12 +
           x * (1. / 720 + x * (1. / 30240 +
                                x * (1. / 1209600 + x * (1. / 47900160 + x * (691. / 1307674368000 +
                                                                              x / 74724249600)))));
  }
  return 1 / (t * t) - 1 / (2 * t * std::tan(t / 2));
}

}  // namespace

Eigen::Matrix3d exp(const Eigen::Vector3d& phi) {
  const double t = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  return Eigen::Matrix3d::Identity() + s1(t) * W + s2(t) * W * W;
}

Eigen::Vector3d log(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double n = q.vec().norm();
  // 2 atan(n/w)/n; below the limit n/w is so small that the first two terms are exact.
  const double factor =
      n < 1e-4 ? 2 / q.w() * (1 - n * n / (3 * q.w() * q.w())) : 2 * std::atan2(n, q.w()) / n;
  return factor * q.vec();
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) {
  const double t = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  return Eigen::Matrix3d::Identity() + s2(t) * W + s3(t) * W * W;
}

Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi) {
  const Eigen::Matrix3d W = hat(phi);
  return Eigen::Matrix3d::Identity() - 0.5 * W + inverse_coefficient(phi.norm()) * W * W;
}

Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) { return left_jacobian(-phi); }

Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) {
  return left_jacobian_inverse(-phi);
}

Eigen::Matrix3d gamma2(const Eigen::Vector3d& phi) {
  const double t = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  return 0.5 * Eigen::Matrix3d::Identity() + s3(t) * W + s4(t) * W * W;
}

Eigen::Matrix3d normalized(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

Eigen::Matrix3d between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized(), normal = a.cross(b);
  const double cosine = b.dot(a);
  if (cosine < kNearlyOpposite) {
    // 1 + cosine loses digits. A half turn takes a to -a, which is close to the target.
    Eigen::Vector3d axis = normal - a.dot(normal) * a;
    axis = axis.norm() > 1e-14 ? axis.normalized() : a.unitOrthogonal();
    return between(-a, b) * (2 * axis * axis.transpose() - Eigen::Matrix3d::Identity());
  }
  const double twice_half_cosine = std::sqrt((1 + cosine) * 2);
  Eigen::Quaterniond turn;
  turn.vec() = normal * (1 / twice_half_cosine);
  turn.w() = twice_half_cosine * 0.5;
  return turn.toRotationMatrix();
}

Eigen::Matrix3d left_jacobian_coupling(const Eigen::Vector3d& phi, const Eigen::Vector3d& rho) {
  const double t = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  const Eigen::Matrix3d V = hat(rho);
  const Eigen::Matrix3d WV = W * V;
  const Eigen::Matrix3d VW = V * W;
  const Eigen::Matrix3d WVW = WV * W;
  return 0.5 * V + s3(t) * (WV + VW + WVW) + s4(t) * (W * WV + VW * W - 3 * WVW) +
         0.5 * (s4(t) - 3 * s5(t)) * (WVW * W + W * WVW);
}

}  // namespace so3
}  // namespace chasles
