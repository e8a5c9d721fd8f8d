#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <chasles/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/map/joint_covariance.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// B with B B^T = P of one point, and its inverse where P is regular.
struct Root {
  Matrix3d B, inverse;
};

Root root(const Matrix3d& P) {
  constexpr double kSingular = 1e-10;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(P);
  const Eigen::Vector3d values = solver.eigenvalues().cwiseMax(0);
  Root result{Matrix3d::Zero(), Matrix3d::Zero()};
  for (int i = 0; i < 3; ++i) {
    if (!(values(i) > kSingular * values(2))) continue;
    const Eigen::Vector3d axis = solver.eigenvectors().col(i);
    result.B.col(i) = std::sqrt(values(i)) * axis;
    result.inverse.row(i) = axis.transpose() / std::sqrt(values(i));
  }
  return result;
}

MatrixXd orthonormal(const MatrixXd& A) {
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return qr.householderQ() * MatrixXd::Identity(A.rows(), A.cols());
}

// The largest eigenvalues and vectors of a positive semidefinite K, from its products with random
// vectors (Halko, Martinsson & Tropp, SIAM Review 2011, with one power iteration). What remains of
// K is positive semidefinite but for rounding.
MatrixXd largest_directions(const MatrixXd& K, int most) {
  constexpr int kMore = 8;
  const Index columns = std::min<Index>(K.rows(), most + kMore);
  std::mt19937_64 random(1);  // NOLINT(cert-msc51-cpp): same bytes every time
  MatrixXd A(K.rows(), columns);
  for (Index j = 0; j < columns; ++j) {
    for (Index i = 0; i < K.rows(); ++i) A(i, j) = (random() & 1U) != 0 ? 1 : -1;
  }
  const MatrixXd Q = orthonormal(dense::product(K, orthonormal(dense::product(K, A))));
  const MatrixXd KQ = dense::product(K, Q), Q_transposed = Q.transpose();
  const MatrixXd small = dense::product(Q_transposed, KQ);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver((small + small.transpose()) / 2);
  const Index rank = std::min<Index>(most, columns);
  MatrixXd U(K.rows(), rank);
  for (Index i = 0; i < rank; ++i) {  // the largest first
    const Index from = columns - 1 - i;
    const double value = std::max(solver.eigenvalues()(from), 0.0);
    U.col(i) = std::sqrt(value) * (Q * solver.eigenvectors().col(from));
  }
  return U;
}

// Root mean square of what U U^T leaves of the correlations of different points.
double remainder(const MatrixXd& K, const MatrixXd& U) {
  const MatrixXd U_transposed = U.transpose();
  MatrixXd left = K - dense::product(U, U_transposed);
  for (Index i = 0; i < K.rows(); i += 3) left.block<3, 3>(i, i).setZero();
  return std::sqrt(left.squaredNorm() / static_cast<double>(K.size()));
}

}  // namespace

JointCovariance::JointCovariance(std::vector<Matrix3d> own, Eigen::MatrixXf shared)
    : own_(std::move(own)), shared_(std::move(shared)) {
  if (shared_.rows() != 3 * static_cast<Index>(own_.size())) {
    throw UsageError("the joint covariance of points has three rows for each of them");
  }
}

JointCovariance JointCovariance::compressed(const MatrixXd& P, double error, int most) {
  if (P.rows() != P.cols() || P.rows() % 3 != 0) {
    throw UsageError("the joint covariance of points has three rows for each of them");
  }
  const Index n = P.rows();
  if (n == 0) return {};
  std::vector<Root> roots;
  MatrixXd K = P;
  for (Index i = 0; i < n; i += 3) roots.push_back(root(P.block<3, 3>(i, i)));
  for (Index i = 0; i < n; i += 3) {
    const Matrix3d& inverse = roots[static_cast<std::size_t>(i / 3)].inverse;
    K.middleRows<3>(i) = (inverse * K.middleRows<3>(i)).eval();
  }
  for (Index i = 0; i < n; i += 3) {
    const Matrix3d& inverse = roots[static_cast<std::size_t>(i / 3)].inverse;
    K.middleCols<3>(i) = (K.middleCols<3>(i) * inverse.transpose()).eval();
  }
  MatrixXd U = largest_directions(K, most);
  constexpr Index kStep = 8;
  for (Index rank = kStep; rank < U.cols(); rank += kStep) {
    if (remainder(K, U.leftCols(rank)) < error) {
      U = U.leftCols(rank).eval();
      break;
    }
  }
  std::vector<Matrix3d> own;
  Eigen::MatrixXf shared(n, U.cols());
  for (Index i = 0; i < n; i += 3) {
    const MatrixXd rows = roots[static_cast<std::size_t>(i / 3)].B * U.middleRows<3>(i);
    shared.middleRows<3>(i) = rows.cast<float>();
    const MatrixXd rounded = shared.middleRows<3>(i).cast<double>();
    const Matrix3d rest = P.block<3, 3>(i, i) - rounded * rounded.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver((rest + rest.transpose()) / 2);
    const Matrix3d V = solver.eigenvectors();
    own.push_back(V * solver.eigenvalues().cwiseMax(0).asDiagonal() * V.transpose());
  }
  return {std::move(own), std::move(shared)};
}

JointCovariance JointCovariance::part(std::span<const int> points) const {
  const auto n = static_cast<Index>(points.size());
  std::vector<Matrix3d> own;
  Eigen::MatrixXf shared(3 * n, rank());
  for (Index i = 0; i < n; ++i) {
    const int point = points[static_cast<std::size_t>(i)];
    own.push_back(own_[static_cast<std::size_t>(point)]);
    shared.middleRows<3>(3 * i) = shared_.middleRows<3>(3 * static_cast<Index>(point));
  }
  return {std::move(own), std::move(shared)};
}

Matrix3d JointCovariance::of(int point) const {
  const MatrixXd U = shared_.middleRows<3>(3 * static_cast<Index>(point)).cast<double>();
  return own_[static_cast<std::size_t>(point)] + U * U.transpose();
}

MatrixXd JointCovariance::of(std::span<const int> points) const {
  const auto n = static_cast<Index>(points.size());
  MatrixXd U(3 * n, rank());
  for (Index i = 0; i < n; ++i) {
    const Index from = 3 * static_cast<Index>(points[static_cast<std::size_t>(i)]);
    U.middleRows<3>(3 * i) = shared_.middleRows<3>(from).cast<double>();
  }
  const MatrixXd U_transposed = U.transpose();
  MatrixXd P = rank() > 0 ? dense::product(U, U_transposed) : MatrixXd::Zero(3 * n, 3 * n);
  for (Index i = 0; i < n; ++i) {
    P.block<3, 3>(3 * i, 3 * i) +=
        own_[static_cast<std::size_t>(points[static_cast<std::size_t>(i)])];
  }
  return P;
}

}  // namespace chasles
