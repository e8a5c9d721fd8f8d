#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

/// Independent computation: the reference for the closed forms in the tests of this folder.
/// Included by tests only.
namespace chasles::test {

using ExtendedMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// Sum over k of A^k / (k+n)!, in extended precision, until the terms are negligible: the
/// exponential for n = 0, its first integral for n = 1. Accurate to double precision for |A| < 10,
/// where the largest term is about 3e3 and costs 4 of the 19 digits.
inline Eigen::MatrixXd series(const Eigen::MatrixXd& A, int n) {
  const ExtendedMatrix a = A.cast<long double>();
  ExtendedMatrix term = ExtendedMatrix::Identity(A.rows(), A.cols());
  for (int i = 2; i <= n; ++i) term /= i;
  ExtendedMatrix sum = term;
  for (int k = 1; k < 80; ++k) {
    term = (term * a / (k + n)).eval();
    sum += term;
  }
  return sum.cast<double>();
}

/// The inverse, in extended precision.
inline Eigen::MatrixXd inverse(const Eigen::MatrixXd& A) {
  return A.cast<long double>().eval().inverse().cast<double>();
}

}  // namespace chasles::test
