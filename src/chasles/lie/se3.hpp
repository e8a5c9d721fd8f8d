#pragma once

#include <Eigen/Core>

#include <chasles/lie/so3.hpp>

namespace chasles {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid motion. `a_T_b` maps coordinates of b to a: p_a = a_T_b * p_b.
struct SE3 {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();

  SE3 operator*(const SE3& other) const { return {R * other.R, R * other.p + p}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return R * point + p; }
  SE3 inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// The group of rigid motions. A tangent vector (a twist) is [phi; rho]: rotation first [rad],
/// translation second [m]. Kleinert & Stilla (2) and all error states of this project use this
/// order. Du (7) uses the opposite order.
///
/// Invariants (asserted in se3_test.cpp, same angles as SO(3)):
///   1. exp(xi) = sum of the 4x4 hat(xi)^k / k!
///   2. log(exp(xi)) = xi
///   3. X exp(xi) X^-1 = exp(adjoint(X) xi)
///   4. exp(xi + d) = exp(left_jacobian(xi) d) exp(xi) + O(d^2)
///   5. the inverse Jacobian is the inverse
namespace se3 {

SE3 exp(const Vector6d& xi);
Vector6d log(const SE3& X);

/// [[R, 0], [hat(p) R, R]].
Matrix6d adjoint(const SE3& X);

/// [[Jl, 0], [Q, Jl]].
Matrix6d left_jacobian(const Vector6d& xi);
Matrix6d left_jacobian_inverse(const Vector6d& xi);
Matrix6d right_jacobian(const Vector6d& xi);
Matrix6d right_jacobian_inverse(const Vector6d& xi);

}  // namespace se3
}  // namespace chasles
