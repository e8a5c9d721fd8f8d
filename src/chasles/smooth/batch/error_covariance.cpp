#include <algorithm>
#include <utility>

#include <chasles/smooth/batch/error_covariance_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// The columns of a symmetric matrix; in the matrix, their rows and columns become the identity's.
Eigen::MatrixXd take(const std::vector<int>& columns, Eigen::SparseMatrix<double>& lower) {
  std::vector<int> place(static_cast<std::size_t>(lower.rows()), -1);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    place[static_cast<std::size_t>(columns[i])] = static_cast<int>(i);
  }
  Eigen::MatrixXd taken = Eigen::MatrixXd::Zero(lower.rows(), std::ssize(columns));
  for (int j = 0; j < lower.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(lower, j); entry; ++entry) {
      const int row = place[static_cast<std::size_t>(entry.row())];
      const int column = place[static_cast<std::size_t>(j)];
      if (row < 0 && column < 0) continue;
      if (row >= 0) taken(j, row) = entry.value();
      if (column >= 0) taken(entry.row(), column) = entry.value();
      entry.valueRef() = entry.row() == j ? 1 : 0;
    }
  }
  for (const int column : columns) taken.row(column).setZero();
  return taken;
}

}  // namespace

Eigen::MatrixXd ErrorCovariance::take_columns(NormalEquations& equations) const {
  for (const int row : considered_.rows) equations.gradient[row] = 0;
  return take(considered_.rows, equations.lower);
}

ErrorCovariance::ErrorCovariance(NormalEquations equations, ConsideredErrors considered,
                                 const std::function<bool()>& stop)
    : considered_(std::move(considered)),
      by_considered_(take_columns(equations)),
      inverse_(equations.lower, stop) {
  for (Eigen::Index i = 0; i < by_considered_.cols(); ++i) {
    by_considered_.col(i) = -inverse_.times(by_considered_.col(i));
    by_considered_(considered_.rows[static_cast<std::size_t>(i)], i) = 1;
  }
  squared_distance_ = equations.gradient.dot(inverse_.times(equations.gradient));
}

Eigen::MatrixXd ErrorCovariance::block(const std::vector<int>& rows, double share) const {
  Eigen::MatrixXd P = inverse_.block(rows);
  if (considered_.rows.empty()) return P;
  Eigen::MatrixXd S(std::ssize(rows), by_considered_.cols());
  for (Eigen::Index i = 0; i < S.rows(); ++i) {
    const int row = rows[static_cast<std::size_t>(i)];
    S.row(i) = by_considered_.row(row);
    if (std::ranges::find(considered_.rows, row) == considered_.rows.end()) continue;
    P.row(i).setZero();
    P.col(i).setZero();
  }
  return P + share * S * considered_.covariance * S.transpose();
}

}  // namespace chasles::smooth_detail
