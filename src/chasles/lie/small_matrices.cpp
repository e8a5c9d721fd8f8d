#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool lower_is_finite(const small::ConstMatrix& A) {
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    if (!A.col(j).tail(A.rows() - j).allFinite()) return false;
  }
  return true;
}

}  // namespace

namespace small {
namespace {

constexpr int kMost = kMostSmallRows;
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
using SmallColumn = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

void check_size(const ConstMatrix& A) {
  if (std::max(A.rows(), A.cols()) > kMost) {
    throw std::invalid_argument("small_matrices: at most " + std::to_string(kMost) +
                                " rows and columns");
  }
}

// Column by column: for so few rows, block products do not pay for their packing.
template <typename Decomposition>
void solve_columns(const Decomposition& A, Matrix X) {
  for (Eigen::Index column = 0; column < X.cols(); ++column) {
    const SmallColumn b = X.col(column);
    X.col(column) = A.solve(b);
  }
}
}  // namespace

void solve_symmetric(const ConstMatrix& A, Matrix X) {
  check_size(A);
  if (lower_is_finite(A)) {
    solve_columns(Eigen::LDLT<Small>(A), X);
  } else {
    X.setConstant(kNaN);  // Eigen would return a pivot of 0
  }
}

void solve(const ConstMatrix& A, Matrix X) {
  check_size(A);
  solve_columns(Eigen::PartialPivLU<Small>(A), X);
}

Eigen::MatrixXd inverse_symmetric(const ConstMatrix& A) {
  Eigen::MatrixXd X = Eigen::MatrixXd::Identity(A.rows(), A.cols());
  solve_symmetric(A, X);
  return X;
}

Eigen::MatrixXd inverse(const ConstMatrix& A) {
  Eigen::MatrixXd X = Eigen::MatrixXd::Identity(A.rows(), A.cols());
  solve(A, X);
  return X;
}

void congruence(const ConstMatrix& T, const ConstMatrix& P, Matrix result) {
  check_size(T);
  check_size(P);
  const Small TP = T.lazyProduct(P);
  result = TP.lazyProduct(T.transpose());
}

}  // namespace small

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  if (!lower_is_finite(A)) {
    return {.values = Eigen::VectorXd::Constant(A.rows(), kNaN),
            .vectors = Eigen::MatrixXd::Constant(A.rows(), A.cols(), kNaN)};
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

std::optional<Eigen::MatrixXd> whitening_of(const Eigen::MatrixXd& covariance) {
  // Scaled to a unit diagonal, because the blocks differ by many powers of ten.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = covariance.cwiseProduct(scale * scale.transpose());
  const Eigen::LLT<Eigen::MatrixXd> cholesky(unit);
  if (!scale.allFinite() || cholesky.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd whitening = scale.asDiagonal();
  cholesky.matrixL().solveInPlace(whitening);
  return whitening;
}

}  // namespace chasles
