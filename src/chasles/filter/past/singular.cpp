#include <algorithm>
#include <vector>

#include <Eigen/QR>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/singular.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd sigmas(const MatrixXd& P) {
  VectorXd sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  for (double& s : sigma) s = s > 0 ? s : 1;
  return sigma;
}

MatrixXd regular_root(const MatrixXd& P) {
  constexpr double kAdded = 1e-12;
  const VectorXd sigma = sigmas(P);
  const VectorXd scale = sigma.cwiseInverse();
  for (double added = kAdded; added < 1; added *= 100) {
    MatrixXd L = scale.asDiagonal() * P * scale.asDiagonal();
    L.diagonal().array() += added;
    if (!dense::cholesky(L)) continue;
    L.triangularView<Eigen::StrictlyUpper>().setZero();
    return sigma.asDiagonal() * L;
  }
  return sigma.asDiagonal();  // P is no covariance
}

MatrixXd range_of(const MatrixXd& F) {
  const Index n = F.rows();
  MatrixXd S(n, n);
  const MatrixXd F_transposed = F.transpose();
  dense::square_lower(F_transposed, S);
  std::vector<int> order;
  Scratch workspace;
  const Index rank = dense::pivoted_cholesky(S, order, workspace);
  MatrixXd spanning = MatrixXd::Zero(n, rank);
  for (Index i = 0; i < n; ++i) {
    const Index columns = std::min(i + 1, rank);
    spanning.row(order[static_cast<std::size_t>(i)]).head(columns) = S.row(i).head(columns);
  }
  const Eigen::HouseholderQR<MatrixXd> qr(spanning);
  return qr.householderQ() * MatrixXd::Identity(n, rank);
}

}  // namespace chasles
