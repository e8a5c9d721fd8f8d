#pragma once

#include <optional>

#include <Eigen/Core>

/// Matrices solved, inverted and taken apart, by Eigen's decompositions: each compiled once, in
/// small_matrices.cpp. Eigen writes a decomposition anew for every size that a file uses, and much
/// of that file's compiling is then the decomposition. What runs for every measurement of a frame
/// is better off with Eigen's fixed sizes.
namespace chasles {

inline constexpr int kMostSmallRows = 20;

/// Of sizes that are told at run time: at most kMostSmallRows rows, of P, A and T too; throws
/// std::invalid_argument for more.
namespace small {
using Matrix = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// X <- A^-1 X for a symmetric A (n x n; its lower triangle is read), by L D L^T with pivots: A may
/// be indefinite, and where it is singular, what it does not tell of X is 0. Not finite where A or
/// X is not. Without memory of the heap.
void solve_symmetric(const ConstMatrix& A, Matrix X);

/// X <- A^-1 X for any regular A, by L U with pivots of rows. Not finite where A is singular.
/// Without memory of the heap.
void solve(const ConstMatrix& A, Matrix X);

/// A^-1 by these.
Eigen::MatrixXd inverse_symmetric(const ConstMatrix& A);
Eigen::MatrixXd inverse(const ConstMatrix& A);

/// result <- T P T^T.
void congruence(const ConstMatrix& T, const ConstMatrix& P, Matrix result);
}  // namespace small

/// A^-1 B for a symmetric A, see small::solve_symmetric.
template <int N, int Columns>
Eigen::Matrix<double, N, Columns> solve_symmetric(const Eigen::Matrix<double, N, N>& A,
                                                  Eigen::Matrix<double, N, Columns> B) {
  static_assert(N <= kMostSmallRows);
  small::solve_symmetric(A, B);
  return B;
}

/// A^-1 for a symmetric A, see small::solve_symmetric.
template <int N>
Eigen::Matrix<double, N, N> inverse_symmetric(const Eigen::Matrix<double, N, N>& A) {
  return solve_symmetric<N, N>(A, Eigen::Matrix<double, N, N>::Identity());
}

/// A^-1 B for any regular A, see small::solve.
template <int N, int Columns>
Eigen::Matrix<double, N, Columns> solve(const Eigen::Matrix<double, N, N>& A,
                                        Eigen::Matrix<double, N, Columns> B) {
  static_assert(N <= kMostSmallRows);
  small::solve(A, B);
  return B;
}

/// A^-1 for any regular A, see small::solve.
template <int N>
Eigen::Matrix<double, N, N> inverse(const Eigen::Matrix<double, N, N>& A) {
  return solve<N, N>(A, Eigen::Matrix<double, N, N>::Identity());
}

/// T P T^T: a covariance P of x as that of T x.
template <int Rows, int N>
Eigen::Matrix<double, Rows, Rows> congruence(const Eigen::Matrix<double, Rows, N>& T,
                                             const Eigen::Matrix<double, N, N>& P) {
  static_assert(Rows <= kMostSmallRows && N <= kMostSmallRows);
  Eigen::Matrix<double, Rows, Rows> result;
  small::congruence(T, P, result);
  return result;
}

/// A symmetric A = V diag(values) V^T.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< from the least on
  Eigen::MatrixXd vectors;  ///< V: of length 1, one a column
};

/// Of any size; the lower triangle of A is read. All NaN where that is not finite.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

/// Lower triangular W with W^T W = covariance^-1, of any size; none where the covariance is not
/// positive definite.
std::optional<Eigen::MatrixXd> whitening_of(const Eigen::MatrixXd& covariance);

}  // namespace chasles
