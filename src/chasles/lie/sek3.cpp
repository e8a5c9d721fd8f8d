#include <chasles/lie/sek3.hpp>

namespace chasles::sek3 {
namespace {

Eigen::Index count(const Eigen::VectorXd& xi) { return xi.size() / 3 - 1; }

// Lower block-triangular: D on the diagonal, column(i) below the first.
template <typename Column>
Eigen::MatrixXd blocks(const Eigen::Matrix3d& D, Eigen::Index k, Column column) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(3 + 3 * k, 3 + 3 * k);
  A.topLeftCorner<3, 3>() = D;
  for (Eigen::Index i = 0; i < k; ++i) {
    A.block<3, 3>(3 + 3 * i, 0) = column(i);
    A.block<3, 3>(3 + 3 * i, 3 + 3 * i) = D;
  }
  return A;
}

}  // namespace

SEk3 exp(const Eigen::VectorXd& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  const Eigen::Map<const Eigen::Matrix3Xd> rho(xi.data() + 3, 3, count(xi));
  return {so3::exp(phi), so3::left_jacobian(phi) * rho};
}

Eigen::VectorXd log(const SEk3& X) {
  const Eigen::Vector3d phi = so3::log(X.R);
  const Eigen::Matrix3Xd rho = so3::left_jacobian_inverse(phi) * X.x;
  Eigen::VectorXd xi(3 + rho.size());
  xi << phi, rho.reshaped();
  return xi;
}

Eigen::MatrixXd adjoint(const SEk3& X) {
  return blocks(X.R, X.x.cols(),
                [&](Eigen::Index i) -> Eigen::Matrix3d { return hat(X.x.col(i)) * X.R; });
}

Eigen::MatrixXd left_jacobian(const Eigen::VectorXd& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  return blocks(so3::left_jacobian(phi), count(xi), [&](Eigen::Index i) {
    return so3::left_jacobian_coupling(phi, xi.segment<3>(3 + 3 * i));
  });
}

Eigen::MatrixXd left_jacobian_inverse(const Eigen::VectorXd& xi) {
  const Eigen::Vector3d phi = xi.head<3>();
  const Eigen::Matrix3d J = so3::left_jacobian_inverse(phi);
  return blocks(J, count(xi), [&](Eigen::Index i) -> Eigen::Matrix3d {
    return -J * so3::left_jacobian_coupling(phi, xi.segment<3>(3 + 3 * i)) * J;
  });
}

Eigen::MatrixXd right_jacobian(const Eigen::VectorXd& xi) { return left_jacobian(-xi); }
Eigen::MatrixXd right_jacobian_inverse(const Eigen::VectorXd& xi) {
  return left_jacobian_inverse(-xi);
}

}  // namespace chasles::sek3
