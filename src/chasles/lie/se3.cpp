#include <chasles/lie/se3.hpp>

namespace chasles::se3 {

SE3 exp(const Vector6d& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  return {so3::exp(phi), so3::left_jacobian(phi) * xi.tail<3>()};
}

Vector6d log(const SE3& X) {
  const Eigen::Vector3d phi = so3::log(X.R);
  Vector6d xi;
  xi << phi, so3::left_jacobian_inverse(phi) * X.p;
  return xi;
}

Matrix6d adjoint(const SE3& X) {
  Matrix6d A;
  A << X.R, Eigen::Matrix3d::Zero(), hat(X.p) * X.R, X.R;
  return A;
}

Matrix6d left_jacobian(const Vector6d& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  const Eigen::Matrix3d J = so3::left_jacobian(phi);
  Matrix6d A;
  A << J, Eigen::Matrix3d::Zero(), so3::left_jacobian_coupling(phi, xi.tail<3>()), J;
  return A;
}

Matrix6d left_jacobian_inverse(const Vector6d& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  const Eigen::Matrix3d J = so3::left_jacobian_inverse(phi);
  Matrix6d A;
  A << J, Eigen::Matrix3d::Zero(), -J * so3::left_jacobian_coupling(phi, xi.tail<3>()) * J, J;
  return A;
}

Matrix6d right_jacobian(const Vector6d& xi) { return left_jacobian(-xi); }
Matrix6d right_jacobian_inverse(const Vector6d& xi) { return left_jacobian_inverse(-xi); }

}  // namespace chasles::se3
