#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include <chasles/smooth/batch/supernodal_cholesky.hpp>

namespace chasles {

/// Selected entries of the inverse of a large sparse symmetric positive definite matrix: all where
/// the matrix itself has an entry, and more. Uses the recursion of Takahashi, Fagan & Chin (1973)
/// upwards through the Cholesky factor. The whole inverse is never formed.
class SelectedInverse {
 public:
  /// `lower`: the matrix's lower triangle, diagonal included. Throws Error(kDiverged) where it is
  /// not positive definite to working precision, and BatchStopped where `stop` returns true.
  explicit SelectedInverse(const Eigen::SparseMatrix<double>& lower,
                           const std::function<bool()>& stop = {});

  /// The inverse times a vector.
  Eigen::VectorXd times(const Eigen::VectorXd& b) const { return cholesky_.solve(b); }

  /// Entry (row, column) of the inverse; it must be one of those that were computed.
  double operator()(int row, int column) const;
  Eigen::MatrixXd block(const std::vector<int>& indices) const;  ///< of these rows and columns

 private:
  void invert(const std::function<bool()>& stop);
  void gather(const std::vector<int>& rows, int from, Eigen::MatrixXd& Z) const;

  SupernodalCholesky cholesky_;
  std::vector<Eigen::MatrixXd> Z_;  ///< of each of its nodes: rows x width of the inverse
};

}  // namespace chasles
