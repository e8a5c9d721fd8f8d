#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace chasles {

/// The Cholesky factor of a large sparse symmetric positive definite matrix, P H P^T = L L^T with a
/// fill-reducing permutation P, in dense blocks of columns that have the same rows (supernodes). It
/// is the multifrontal method of Duff & Reid (1983).
class SupernodalCholesky {
 public:
  /// Columns [first, first + width) of L.
  struct Node {
    int first = 0, width = 0;
    std::vector<int> rows = {};  ///< of L, rising: the columns themselves and those below
    int parent = -1;             ///< the node of the first row below; -1: none
    Eigen::MatrixXd L = {};      ///< rows x width; the upper triangle is not defined
    int below() const { return static_cast<int>(rows.size()) - width; }
  };

  /// `lower`: the lower triangle of H, diagonal included. Throws Error(kDiverged) where H is not
  /// positive definite to working precision, and BatchStopped where `stop` returns true.
  explicit SupernodalCholesky(const Eigen::SparseMatrix<double>& lower,
                              const std::function<bool()>& stop = {});

  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;  ///< H^-1 b

  const std::vector<Node>& nodes() const { return nodes_; }  ///< each before its parent
  /// The place of a row of H in P H P^T, and the node of a column there.
  int place(int row) const { return place_[static_cast<std::size_t>(row)]; }
  int node_of(int column) const { return node_of_[static_cast<std::size_t>(column)]; }

 private:
  void find_nodes(const Eigen::SparseMatrix<double>& H);
  void factorise(const Eigen::SparseMatrix<double>& H, const std::function<bool()>& stop);

  std::vector<int> place_, node_of_;
  std::vector<Node> nodes_;
};

}  // namespace chasles
