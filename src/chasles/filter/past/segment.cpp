#include <algorithm>
#include <iterator>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/segment.hpp>

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

MatrixXd symmetric_part(const MatrixXd& M) { return (M + M.transpose()) / 2; }

}  // namespace

std::ptrdiff_t Segment::place(int number) const {
  Index at = starts;
  for (const Item& item : items) {
    if (item.number == number) return at;
    at += item.size;
  }
  return -1;
}

std::vector<Index> variables_of(const Segment& segment, const std::vector<int>& numbers) {
  Indices variables;
  Index at = segment.starts;
  for (const Segment::Item& item : segment.items) {
    if (contains(numbers, item.number)) append_rows(variables, at, item.size);
    at += item.size;
  }
  return variables;
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
  const Indices of_items = variables_of(segment, numbers);
  variables.insert(variables.end(), of_items.begin(), of_items.end());
  std::ranges::copy_if(segment.items, std::back_inserter(result.items),
                       [&](const Segment::Item& item) { return contains(numbers, item.number); });
  result.X = segment.X(Eigen::all, variables);
  result.G = segment.G(variables, variables);
  result.g = segment.g(variables);
  return result;
}

Segment with_derived(const Segment& segment, int source, const std::vector<DerivedItem>& derived) {
  if (derived.empty()) return segment;
  const Index q = segment.g.size(), from = segment.place(source);
  const Index size = std::ranges::find(segment.items, source, &Segment::Item::number)->size;
  Index k = 0;
  for (const DerivedItem& one : derived) k += one.item.size;
  MatrixXd A(k, size);
  std::vector<Segment::Item> items = segment.items;
  Index at = 0;
  for (const DerivedItem& one : derived) {
    A.middleRows(at, one.item.size) = one.by_source;
    items.push_back(one.item);
    at += one.item.size;
  }
  const MatrixXd A_transposed = A.transpose();
  const MatrixXd with_others = dense::product(A, segment.G.middleRows(from, size));
  MatrixXd X(segment.X.rows(), q + k), G(q + k, q + k);
  VectorXd g(q + k);
  X << segment.X, dense::product(segment.X.middleCols(from, size), A_transposed);
  G << segment.G, with_others.transpose(), with_others,
      symmetric_part(dense::product(with_others.middleCols(from, size), A_transposed));
  g << segment.g, A * segment.g.segment(from, size);
  at = q;
  for (const DerivedItem& one : derived) {
    G.block(at, at, one.item.size, one.item.size) += one.own;
    at += one.item.size;
  }
  // By number.
  std::vector<std::pair<Segment::Item, Index>> places;
  at = segment.starts;
  for (const Segment::Item& item : items) {
    places.emplace_back(item, at);
    at += item.size;
  }
  std::ranges::sort(places, {}, [](const auto& place) { return place.first.number; });
  Segment result{
      .starts = segment.starts, .items = {}, .X = {}, .G = {}, .g = {}, .length = segment.length};
  Indices order;
  append_rows(order, 0, segment.starts);
  for (const auto& [item, first] : places) {
    result.items.push_back(item);
    append_rows(order, first, item.size);
  }
  result.X = X(Eigen::all, order);
  result.G = G(order, order);
  result.g = g(order);
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
  const Indices rows = variables_of(segment, numbers);
  std::ranges::copy_if(segment.items, std::back_inserter(past.items),
                       [&](const Segment::Item& item) { return contains(numbers, item.number); });
  const auto k = static_cast<Index>(rows.size());
  MatrixXd C(r + k, segment.X.rows()), P(r + k, r + k);
  VectorXd correction(r + k);
  if (r > 0) {
    const MatrixXd starts = segment.X.leftCols(n).transpose();
    C.topRows(r) = dense::product(past.C, starts);
    const MatrixXd moved = dense::product(past.C, segment.G.topLeftCorner(n, n));
    const MatrixXd C_transposed = past.C.transpose(), own = segment.G.topRows(n)(Eigen::all, rows);
    P.topLeftCorner(r, r) = symmetric_part(past.P + dense::product(moved, C_transposed));
    dense::multiply(past.C, own, P.topRightCorner(r, k));
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
