#pragma once

#include <functional>
#include <vector>

#include <Eigen/SparseCholesky>

namespace chasles {

/// Selected entries of the inverse of a large sparse symmetric positive definite matrix: all where
/// the matrix itself has an entry, and more. Uses the recursion of Takahashi, Fagan & Chin (1973)
/// upwards through the Cholesky factor, with column blocks of equal pattern. The whole inverse is
/// never formed.
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
  // Columns [first, first + width) of the permuted factor, which have the same rows.
  struct Supernode {
    int first = 0, width = 0;
    std::vector<int> rows = {};  // the columns themselves and those below
    Eigen::MatrixXd Z = {};      // rows x width: the inverse
  };
  void find_nodes(const Eigen::SparseMatrix<double>& L);
  void invert(const Eigen::SparseMatrix<double>& L, const Eigen::VectorXd& D,
              const std::function<bool()>& stop);
  void gather(const std::vector<int>& rows, int from, Eigen::MatrixXd& Z) const;

  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>
      cholesky_;
  std::vector<int> place_;      // of a row in the permuted order
  std::vector<int> supernode_;  // of a permuted column
  std::vector<Supernode> nodes_;
};

}  // namespace chasles
