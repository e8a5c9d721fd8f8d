#include <algorithm>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/selected_inverse.hpp>

namespace chasles {

SelectedInverse::SelectedInverse(const Eigen::SparseMatrix<double>& lower,
                                 const std::function<bool()>& stop)
    : cholesky_(lower, stop), Z_(cholesky_.nodes().size()) {
  invert(stop);
}

void SelectedInverse::invert(const std::function<bool()>& stop) {
  Eigen::MatrixXd below;
  for (std::size_t i = Z_.size(); i-- > 0;) {
    if (stop && stop()) throw BatchStopped();
    const SupernodalCholesky::Node& node = cholesky_.nodes()[i];
    const int w = node.width, m = node.below();
    // Z_SJ = -Z_SS M, Z_JJ = (L_JJ L_JJ^T)^-1 - M^T Z_SJ, M = L_SJ L_JJ^-1.
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(w, w);
    dense::solve_lower(node.L.topRows(w), inverse);
    Eigen::MatrixXd& Z = Z_[i];
    Z.resize(w + m, w);
    dense::square_lower(inverse, Z.topRows(w));
    dense::mirror_lower(Z.topRows(w));
    if (m == 0) continue;
    Eigen::MatrixXd minus_M(m, w);
    minus_M.setZero();
    dense::add_product(-1, node.L.bottomRows(m), inverse, minus_M);
    below.resize(m, m);
    gather(node.rows, w, below);
    Z.bottomRows(m) = dense::symmetric_product(below, minus_M);
    const Eigen::MatrixXd transposed = minus_M.transpose();
    dense::add_product(1, transposed, Z.bottomRows(m), Z.topRows(w));
  }
}

// The lower triangle of Z at rows[from:], which are all complete.
void SelectedInverse::gather(const std::vector<int>& rows, int from, Eigen::MatrixXd& Z) const {
  const int m = static_cast<int>(rows.size()) - from;
  std::vector<int> where(static_cast<std::size_t>(m));
  const auto row = [&](int i) { return rows[static_cast<std::size_t>(from + i)]; };
  for (int c = 0; c < m;) {
    const auto i = static_cast<std::size_t>(cholesky_.node_of(row(c)));
    const SupernodalCholesky::Node& node = cholesky_.nodes()[i];
    int end = c;
    while (end < m && row(end) < node.first + node.width) ++end;
    auto at = node.rows.begin();
    for (int r = c; r < m; ++r) {
      at = std::lower_bound(at, node.rows.end(), row(r));
      where[static_cast<std::size_t>(r)] = static_cast<int>(at - node.rows.begin());
    }
    for (; c < end; ++c) {
      const double* column = Z_[i].col(row(c) - node.first).data();
      for (int r = c; r < m; ++r) Z(r, c) = column[where[static_cast<std::size_t>(r)]];
    }
  }
}

double SelectedInverse::operator()(int row, int column) const {
  int i = cholesky_.place(row), j = cholesky_.place(column);
  if (i < j) std::swap(i, j);
  const auto k = static_cast<std::size_t>(cholesky_.node_of(j));
  const SupernodalCholesky::Node& node = cholesky_.nodes()[k];
  const auto at = std::lower_bound(node.rows.begin(), node.rows.end(), i);
  if (at == node.rows.end() || *at != i) {
    throw Error(ExitCode::kUsage, "the inverse has no entry there");
  }
  return Z_[k](at - node.rows.begin(), j - node.first);
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
