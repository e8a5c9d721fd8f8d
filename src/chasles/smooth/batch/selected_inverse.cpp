#include <algorithm>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/selected_inverse.hpp>

namespace chasles {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Rows of the unit lower triangular factor's column, the diagonal left out; rising.
std::vector<int> rows_below(const Sparse& L, int column) {
  std::vector<int> rows;
  for (Sparse::InnerIterator it(L, column); it; ++it) {
    if (it.row() > column) rows.push_back(static_cast<int>(it.row()));
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

// Columns [first, first + width) of the unit lower triangular factor at those rows, dense.
Eigen::MatrixXd columns_of(const Sparse& L, int first, int width, const std::vector<int>& rows) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(std::ssize(rows), width);
  for (int c = 0; c < width; ++c) {
    auto at = static_cast<std::size_t>(c);
    for (Sparse::InnerIterator it(L, first + c); it; ++it) {
      if (it.row() <= first + c) continue;
      while (rows[at] != it.row()) ++at;
      dense(static_cast<Eigen::Index>(at), c) = it.value();
    }
    dense(c, c) = 1;
  }
  return dense;
}

}  // namespace

SelectedInverse::SelectedInverse(const Sparse& lower, const std::function<bool()>& stop)
    : cholesky_(lower) {
  const Eigen::VectorXd D = cholesky_.vectorD();
  if (cholesky_.info() != Eigen::Success || !(D.size() == 0 || D.minCoeff() > 0) ||
      !D.allFinite()) {
    throw Error(ExitCode::kDiverged,
                "the normal matrix of the batch is not positive definite: a state or landmark is "
                "unobservable");
  }
  const Sparse L = cholesky_.matrixL();
  const int n = static_cast<int>(L.cols());
  const auto& permutation = cholesky_.permutationP().indices();
  place_.assign(permutation.data(), permutation.data() + permutation.size());
  if (place_.empty()) {
    place_.resize(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) place_[static_cast<std::size_t>(i)] = i;
  }
  find_nodes(L);
  invert(L, D, stop);
}

// From the left: a column joins the node before it if it has its remaining rows.
void SelectedInverse::find_nodes(const Sparse& L) {
  const int n = static_cast<int>(L.cols());
  supernode_.resize(static_cast<std::size_t>(n));
  std::vector<int> expected;
  for (int j = 0; j < n; ++j) {
    std::vector<int> rows = rows_below(L, j);
    const bool joins = !expected.empty() && expected.front() == j &&
                       std::equal(expected.begin() + 1, expected.end(), rows.begin(), rows.end());
    if (joins) {
      ++nodes_.back().width;
    } else {
      nodes_.push_back({.first = j, .width = 1});
      nodes_.back().rows = {j};
      nodes_.back().rows.insert(nodes_.back().rows.end(), rows.begin(), rows.end());
    }
    supernode_[static_cast<std::size_t>(j)] = static_cast<int>(nodes_.size()) - 1;
    expected = std::move(rows);
  }
}

void SelectedInverse::invert(const Sparse& L, const Eigen::VectorXd& D,
                             const std::function<bool()>& stop) {
  Eigen::MatrixXd below;
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    if (stop && stop()) throw BatchStopped();
    const int w = node->width, m = static_cast<int>(node->rows.size()) - w;
    const Eigen::MatrixXd factor = columns_of(L, node->first, w, node->rows);
    // Z_SJ = -Z_SS M, Z_JJ = (L D L^T)^-1 - M^T Z_SJ, M = L_SJ L_JJ^-1.
    const auto unit = factor.topRows(w).triangularView<Eigen::UnitLower>();
    const Eigen::MatrixXd inverse = unit.solve(Eigen::MatrixXd::Identity(w, w));
    node->Z.resize(w + m, w);
    node->Z.topRows(w).noalias() =
        inverse.transpose() * D.segment(node->first, w).cwiseInverse().asDiagonal() * inverse;
    if (m > 0) {
      const Eigen::MatrixXd M = factor.bottomRows(m) * inverse;
      below.resize(m, m);
      gather(node->rows, w, below);
      node->Z.bottomRows(m).noalias() = below.selfadjointView<Eigen::Lower>() * (-M);
      node->Z.topRows(w).noalias() -= M.transpose() * node->Z.bottomRows(m);
    }
  }
}

// The lower triangle of Z at rows[from:], which are all complete.
void SelectedInverse::gather(const std::vector<int>& rows, int from, Eigen::MatrixXd& Z) const {
  const int m = static_cast<int>(rows.size()) - from;
  std::vector<int> where(static_cast<std::size_t>(m));
  for (int c = 0; c < m;) {
    const Supernode& node =
        nodes_[static_cast<std::size_t>(supernode_[static_cast<std::size_t>(rows[from + c])])];
    int end = c;
    while (end < m && rows[static_cast<std::size_t>(from + end)] < node.first + node.width) ++end;
    auto at = node.rows.begin();
    for (int r = c; r < m; ++r) {
      at = std::lower_bound(at, node.rows.end(), rows[static_cast<std::size_t>(from + r)]);
      where[static_cast<std::size_t>(r)] = static_cast<int>(at - node.rows.begin());
    }
    for (; c < end; ++c) {
      const int column = rows[static_cast<std::size_t>(from + c)] - node.first;
      for (int r = c; r < m; ++r) Z(r, c) = node.Z(where[static_cast<std::size_t>(r)], column);
    }
  }
}

double SelectedInverse::operator()(int row, int column) const {
  int i = place_[static_cast<std::size_t>(row)], j = place_[static_cast<std::size_t>(column)];
  if (i < j) std::swap(i, j);
  const Supernode& node = nodes_[static_cast<std::size_t>(supernode_[static_cast<std::size_t>(j)])];
  const auto at = std::lower_bound(node.rows.begin(), node.rows.end(), i);
  if (at == node.rows.end() || *at != i) {
    throw Error(ExitCode::kUsage, "the inverse has no entry there");
  }
  return node.Z(at - node.rows.begin(), j - node.first);
}

Eigen::MatrixXd SelectedInverse::block(const std::vector<int>& indices) const {
  const auto n = static_cast<Eigen::Index>(indices.size());
  Eigen::MatrixXd B(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      B(i, j) = B(j, i) =
          (*this)(indices[static_cast<std::size_t>(i)], indices[static_cast<std::size_t>(j)]);
    }
  }
  return B;
}

}  // namespace chasles
