#include <algorithm>
#include <numeric>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/passed_segment.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using Part = std::shared_ptr<const MatrixXd>;

MatrixXd side_by_side(const MatrixXd& left, const MatrixXd& right) {
  MatrixXd result(left.rows(), left.cols() + right.cols());
  result << left, right;
  return result;
}

// All further rows of the end: variables x rows.
MatrixXd more_of(const PassedSegment& segment) {
  MatrixXd all(segment.segment->g.size(), segment.more_rows());
  Index at = 0;
  for (const Part& part : segment.more) {
    all.middleCols(at, part->cols()) = *part;
    at += part->cols();
  }
  return all;
}

void set_more(MatrixXd more, PassedSegment& segment) {
  segment.more.clear();
  if (more.cols() > 0) segment.more.push_back(std::make_shared<const MatrixXd>(std::move(more)));
}

// Few parts, none of which is copied often: each is larger than the next.
void append_more(MatrixXd more, PassedSegment& segment) {
  while (!segment.more.empty() && segment.more.back()->cols() <= more.cols()) {
    more = side_by_side(*segment.more.back(), more);
    segment.more.pop_back();
  }
  segment.more.push_back(std::make_shared<const MatrixXd>(std::move(more)));
}

// Columns of zeros, from the column `at` on.
MatrixXd with_columns(const MatrixXd& M, Index at, Index count) {
  MatrixXd result(M.rows(), M.cols() + count);
  result << M.leftCols(at), MatrixXd::Zero(M.rows(), count), M.rightCols(M.cols() - at);
  return result;
}

// Of the first `count` of its further rows, those that only pass.
Index passing(const PassedSegment& segment, Index count) {
  return static_cast<Index>(std::count_if(segment.from.begin(), segment.from.begin() + count,
                                          [](Index from) { return from >= 0; }));
}

// Further rows of the older one's end that the younger one begins with.
Index rows_between(const PassedSegment& older, const PassedSegment& younger) {
  return younger.segment->starts - older.segment->X.rows();
}

// The first `count` of the further rows of the end are rows of X, and those at the start from which
// they come are starts. Landmarks that returned earlier pass earlier, so these are the first.
Segment with_first(const PassedSegment& segment, Index count) {
  const Segment& own = *segment.segment;
  if (count == 0) return own;
  const Index n = own.starts, more = passing(segment, count);
  Segment result{.starts = n + more,
                 .items = own.items,
                 .X = MatrixXd(own.X.rows() + count, own.X.cols() + more),
                 .G = with_columns(own.G, n, more),
                 .g = VectorXd::Zero(own.g.size() + more),
                 .length = own.length};
  result.X << with_columns(own.X, n, more),
      with_columns(more_of(segment).leftCols(count).transpose(), n, more);
  for (Index i = 0; i < count; ++i) {
    const Index from = segment.from[static_cast<std::size_t>(i)];
    if (from >= 0) result.X(own.X.rows() + i, n + from) = 1;
  }
  result.G = with_columns(result.G.transpose(), n, more);
  result.g.head(n) = own.g.head(n);
  result.g.tail(own.g.size() - n) = own.g.tail(own.g.size() - n);
  return result;
}

}  // namespace

void carry(Carried& past, const PassedSegment& segment, const std::vector<int>& numbers) {
  const Index n = segment.segment->starts, r = past.rows(), more = segment.more_rows();
  const MatrixXd before = std::move(past.C);
  if (r > 0) past.C = before.leftCols(n);
  carry(past, *segment.segment, numbers);
  if (more == 0) return;
  MatrixXd C(past.rows(), segment.rows());
  Index at = past.C.cols();
  C.leftCols(at) = past.C;
  const std::vector<Index> items = variables_of(*segment.segment, numbers);
  for (const Part& part : segment.more) {
    auto columns = C.middleCols(at, part->cols());
    if (r > 0) dense::multiply(before.leftCols(n), part->topRows(n), columns.topRows(r));
    columns.bottomRows(past.rows() - r) = (*part)(items, Eigen::all);
    at += part->cols();
  }
  at -= more;
  for (std::size_t i = 0; i < segment.from.size() && r > 0; ++i, ++at) {
    if (segment.from[i] >= 0) C.col(at).head(r) += before.col(n + segment.from[i]);
  }
  past.C = std::move(C);
}

PassedSegment with_returned(const PassedSegment& segment, const Carried& past,
                            const std::vector<int>& numbers) {
  const Segment& own = *segment.segment;
  const std::vector<Index> items = variables_of(own, numbers);
  const Index r = past.rows(), k = static_cast<Index>(items.size()), n = own.starts;
  PassedSegment result = segment;
  if (r + k == 0) return result;
  MatrixXd returned(own.g.size(), r + k);
  if (r > 0) {
    const MatrixXd C = past.C.leftCols(n).transpose();
    dense::multiply(own.G.leftCols(n), C, returned.leftCols(r));
  }
  returned.rightCols(k) = own.G(Eigen::all, items);
  append_more(std::move(returned), result);
  for (Index i = 0; i < r; ++i) result.from.push_back(past.C.cols() - n + i);
  result.from.resize(result.from.size() + items.size(), -1);
  return result;
}

Index starts_of_composed(const PassedSegment& older, const PassedSegment& younger) {
  return older.segment->starts + passing(older, rows_between(older, younger));
}

// A row that returned after the younger one began passes through it, and has a row of the older one
// to add to.
PassedSegment compose(const PassedSegment& older, const PassedSegment& younger) {
  const Index first = rows_between(older, younger);
  const Segment before = with_first(older, first);
  const Index further = before.starts - older.segment->starts;
  const Index starts = younger.segment->starts, q = before.g.size();
  PassedSegment result{
      .segment = std::make_shared<const Segment>(compose(before, *younger.segment)),
      .from = younger.from};
  if (younger.from.empty()) return result;
  MatrixXd more(result.segment->g.size(), younger.more_rows());
  const MatrixXd passed = more_of(younger), X_transposed = before.X.transpose();
  dense::multiply(X_transposed, passed.topRows(starts), more.topRows(q));
  more.bottomRows(more.rows() - q) = passed.bottomRows(more.rows() - q);
  const MatrixXd of_older = more_of(older);
  const Index n = older.segment->starts, own = of_older.rows() - n;
  for (Index i = 0; i < more.cols(); ++i) {
    Index& from = result.from[static_cast<std::size_t>(i)];
    if (from < 0) continue;
    const auto row = of_older.col(first + from);
    more.col(i).head(n) += row.head(n);
    more.col(i).segment(n + further, own) += row.tail(own);
    from = older.from[static_cast<std::size_t>(first + from)];
    if (from >= 0) from -= further;
  }
  set_more(std::move(more), result);
  return result;
}

PassedSegment with_items(const PassedSegment& segment, const std::vector<int>& numbers) {
  std::vector<Index> variables(static_cast<std::size_t>(segment.segment->starts));
  std::iota(variables.begin(), variables.end(), Index{0});
  const std::vector<Index> items = variables_of(*segment.segment, numbers);
  variables.insert(variables.end(), items.begin(), items.end());
  PassedSegment result{
      .segment = std::make_shared<const Segment>(with_items(*segment.segment, numbers)),
      .from = segment.from};
  set_more(more_of(segment)(variables, Eigen::all), result);
  return result;
}

PassedSegment with_derived(const PassedSegment& segment, int source,
                           const std::vector<DerivedItem>& derived) {
  Segment all = *segment.segment;
  const Index rows = all.X.rows(), more = segment.more_rows();
  all.X = side_by_side(all.X.transpose(), more_of(segment)).transpose();
  all = with_derived(all, source, derived);
  PassedSegment result{.segment = {}, .from = segment.from};
  set_more(all.X.bottomRows(more).transpose(), result);
  all.X = all.X.topRows(rows).eval();
  result.segment = std::make_shared<const Segment>(std::move(all));
  return result;
}

PassedSegment without_starts(const PassedSegment& segment) {
  const Segment& own = *segment.segment;
  const Index q = own.g.size() - own.starts;
  Segment rest{.starts = 0,
               .items = own.items,
               .X = own.X.rightCols(q),
               .G = own.G.bottomRightCorner(q, q),
               .g = own.g.tail(q),
               .length = own.length};
  PassedSegment result{.segment = std::make_shared<const Segment>(std::move(rest)),
                       .from = std::vector<Index>(segment.from.size(), -1)};
  set_more(more_of(segment).bottomRows(q), result);
  return result;
}

Segment whole(const PassedSegment& segment) { return with_first(segment, segment.more_rows()); }

}  // namespace chasles
