#pragma once

#include <Eigen/Core>

namespace chasles {

/// The skew-symmetric matrix of a: hat(a) b = a x b.
Eigen::Matrix3d hat(const Eigen::Vector3d& a);

/// The rotation group. A rotation is a 3x3 matrix, a tangent vector phi a rotation vector [rad].
///
/// Invariants (asserted in so3_test.cpp over 0, 1e-12 … 1e-1, up to pi - 1e-6):
///   1. exp(phi) = sum of hat(phi)^k / k!
///   2. log(exp(phi)) = phi for |phi| < pi
///   3. exp(phi + d) = exp(left_jacobian(phi) d) exp(phi) + O(d^2)
///   4. exp(phi + d) = exp(phi) exp(right_jacobian(phi) d) + O(d^2)
///   5. the inverse Jacobians are the inverses
namespace so3 {

/// Rotation of the angle |phi| about phi.
Eigen::Matrix3d exp(const Eigen::Vector3d& phi);

/// The rotation vector of R, of length at most pi; R must be a rotation.
Eigen::Vector3d log(const Eigen::Matrix3d& R);

/// Jl(phi) = sum of hat(phi)^k / (k+1)!, also the V of the SE(3) exponential.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi);
Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi);

/// Jr(phi) = Jl(-phi).
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi);
Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi);

/// sum of hat(phi)^k / (k+2)!: the second integral of the exponential (docs/derivations.md, D2).
Eigen::Matrix3d gamma2(const Eigen::Vector3d& phi);

/// Re-orthonormalised R: removes the round-off that products of rotations accumulate.
Eigen::Matrix3d normalized(const Eigen::Matrix3d& R);

/// The shortest rotation from the direction of `from` to the direction of `to`. For opposite
/// directions: a half turn about an axis perpendicular to both. Neither may be zero.
Eigen::Matrix3d between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The block Q(phi, rho) of the SE(3) left Jacobian: d/d(phi) of [Jl(phi) rho] in the group's sense
/// (Barfoot 2017, eq. 7.86b).
Eigen::Matrix3d left_jacobian_coupling(const Eigen::Vector3d& phi, const Eigen::Vector3d& rho);

}  // namespace so3
}  // namespace chasles
