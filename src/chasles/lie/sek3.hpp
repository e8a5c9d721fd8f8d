#pragma once

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>

namespace chasles {

/// An element of SE_k(3): one rotation and k vectors. k = 1 is SE(3), k = 2 adds a velocity, k = 2
/// + N adds N landmarks. The columns of x (3 x k) are the vectors.
struct SEk3 {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Matrix3Xd x;

  SEk3 operator*(const SEk3& other) const { return {R * other.R, (R * other.x) + x}; }
  SEk3 inverse() const { return {R.transpose(), -(R.transpose() * x)}; }
};

/// The group SE_k(3). A tangent vector is [phi; rho_1; …; rho_k], 3 + 3k numbers.
/// Invariants 1 to 5 of se3.hpp, asserted in sek3_test.cpp for k = 1, 2, 5.
namespace sek3 {

SEk3 exp(const Eigen::VectorXd& xi);
Eigen::VectorXd log(const SEk3& X);
Eigen::MatrixXd adjoint(const SEk3& X);
Eigen::MatrixXd left_jacobian(const Eigen::VectorXd& xi);
Eigen::MatrixXd left_jacobian_inverse(const Eigen::VectorXd& xi);
Eigen::MatrixXd right_jacobian(const Eigen::VectorXd& xi);
Eigen::MatrixXd right_jacobian_inverse(const Eigen::VectorXd& xi);

}  // namespace sek3
}  // namespace chasles
