#include <algorithm>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/segment.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Indices = std::vector<Index>;

void append_rows(Indices& rows, Index first, Index count) {
  for (Index i = 0; i < count; ++i) rows.push_back(first + i);
}

bool contains(const std::vector<int>& numbers, int number) {
  return std::ranges::binary_search(numbers, number);
}

MatrixXd symmetric(const MatrixXd& M) { return (M + M.transpose()) / 2; }

}  // namespace

std::ptrdiff_t Segment::place(int number) const {
  Index at = starts;
  for (const Item& item : items) {
    if (item.number == number) return at;
    at += item.size;
  }
  return -1;
}

Segment compose(const Segment& older, const Segment& younger) {
  const Index n = younger.starts, own = younger.g.size() - n, q = older.g.size();
  const MatrixXd through = dense::product(younger.G.topLeftCorner(n, n), older.X);
  Segment result{.starts = older.starts,
                 .items = older.items,
                 .X = MatrixXd(younger.X.rows(), q + own),
                 .G = MatrixXd(q + own, q + own),
                 .g = VectorXd(q + own),
                 .length = older.length + younger.length};
  result.items.insert(result.items.end(), younger.items.begin(), younger.items.end());
  result.X << dense::product(younger.X.leftCols(n), older.X), younger.X.rightCols(own);
  const MatrixXd X_transposed = older.X.transpose();
  const MatrixXd cross = dense::product(X_transposed, younger.G.topRightCorner(n, own));
  result.G.topLeftCorner(q, q) = older.G;
  dense::add_product_lower(X_transposed, through, result.G.topLeftCorner(q, q));
  result.G.bottomLeftCorner(own, q) = cross.transpose();
  result.G.bottomRightCorner(own, own) = younger.G.bottomRightCorner(own, own);
  dense::mirror_lower(result.G);
  result.g << older.g + X_transposed * younger.g.head(n), younger.g.tail(own);
  return result;
}

Segment with_items(const Segment& segment, const std::vector<int>& numbers) {
  Segment result;
  result.starts = segment.starts;
  result.length = segment.length;
  Indices variables;
  append_rows(variables, 0, segment.starts);
  Index at = segment.starts;
  for (const Segment::Item& item : segment.items) {
    if (contains(numbers, item.number)) {
      result.items.push_back(item);
      append_rows(variables, at, item.size);
    }
    at += item.size;
  }
  result.X = segment.X(Eigen::all, variables);
  result.G = segment.G(variables, variables);
  result.g = segment.g(variables);
  return result;
}

void take_along(Segment& segment, const std::vector<int>& numbers) {
  if (numbers.empty()) return;
  Indices rows;
  for (const int number : numbers) {
    const auto item = std::ranges::find(segment.items, number, &Segment::Item::number);
    append_rows(rows, segment.place(number), item->size);
  }
  MatrixXd X(segment.X.rows() + static_cast<Index>(rows.size()), segment.X.cols());
  X << segment.X, segment.G(rows, Eigen::all);
  segment.X = std::move(X);
}

void carry(Carried& past, const Segment& segment, const std::vector<int>& numbers) {
  const Index n = segment.starts, r = past.rows();
  Indices rows;
  Index at = n;
  for (const Segment::Item& item : segment.items) {
    if (contains(numbers, item.number)) {
      past.items.push_back(item);
      append_rows(rows, at, item.size);
    }
    at += item.size;
  }
  const auto k = static_cast<Index>(rows.size());
  MatrixXd C(r + k, segment.X.rows()), P(r + k, r + k);
  VectorXd correction(r + k);
  if (r > 0) {
    const MatrixXd starts = segment.X.leftCols(n).transpose();
    C.topRows(r) = dense::product(past.C, starts);
    const MatrixXd moved = dense::product(past.C, segment.G.topLeftCorner(n, n));
    const MatrixXd C_transposed = past.C.transpose();
    P.topLeftCorner(r, r) = symmetric(past.P + dense::product(moved, C_transposed));
    P.topRightCorner(r, k) = past.C * segment.G.topRows(n)(Eigen::all, rows);
    P.bottomLeftCorner(k, r) = P.topRightCorner(r, k).transpose();
    correction.head(r) = past.correction + past.C * segment.g.head(n);
  }
  C.bottomRows(k) = segment.X(Eigen::all, rows).transpose();
  P.bottomRightCorner(k, k) = segment.G(rows, rows);
  correction.tail(k) = segment.g(rows);
  past.C = std::move(C);
  past.P = std::move(P);
  past.correction = std::move(correction);
}

}  // namespace chasles
