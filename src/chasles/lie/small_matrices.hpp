#pragma once

#include <optional>

#include <Eigen/Core>

/// Solution, inversion and decomposition of matrices with Eigen. Each decomposition is compiled
/// once, in small_matrices.cpp. Eigen instantiates a decomposition for every size that a file uses,
/// which takes much of the compile time. Code that runs for every measurement of a frame should use
/// Eigen's fixed sizes instead.
namespace chasles {

inline constexpr int kMostSmallRows = 20;

/// Sizes are known at run time. All matrices, including P, A and T, have at most kMostSmallRows
/// rows; throws std::invalid_argument for more.
namespace small {
using Matrix = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstMatrix = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// X <- A^-1 X for a symmetric A (n x n; its lower triangle is read), by L D L^T with pivots. A may
/// be indefinite. If A is singular, the undetermined part of X is 0. The result is not finite if A
/// or X is not. Allocates no heap memory.
void solve_symmetric(const ConstMatrix& A, Matrix X);

/// X <- A^-1 X for any regular A, by L U with row pivots. The result is not finite if A is
/// singular. Allocates no heap memory.
void solve(const ConstMatrix& A, Matrix X);

/// A^-1 by solve_symmetric and by solve.
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

/// T P T^T: the covariance of T x, where P is the covariance of x.
template <int Rows, int N>
Eigen::Matrix<double, Rows, Rows> congruence(const Eigen::Matrix<double, Rows, N>& T,
                                             const Eigen::Matrix<double, N, N>& P) {
  static_assert(Rows <= kMostSmallRows && N <= kMostSmallRows);
  Eigen::Matrix<double, Rows, Rows> result;
  small::congruence(T, P, result);
  return result;
}

/// Eigendecomposition of a symmetric A = V diag(values) V^T.
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< in ascending order
  Eigen::MatrixXd vectors;  ///< V: one unit vector per column
};

/// Any size; reads the lower triangle of A. All NaN if that triangle is not finite.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

/// Lower triangular W with W^T W = covariance^-1, any size; none if the covariance is not positive
/// definite.
std::optional<Eigen::MatrixXd> whitening_of(const Eigen::MatrixXd& covariance);

}  // namespace chasles
