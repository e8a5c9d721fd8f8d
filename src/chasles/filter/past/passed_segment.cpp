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

MatrixXd stacked(const MatrixXd& upper, const MatrixXd& lower) {
  MatrixXd result(upper.rows() + lower.rows(), upper.cols());
  result << upper, lower;
  return result;
}

// Columns of zeros, from the column `at` on.
MatrixXd with_columns(const MatrixXd& M, Index at, Index count) {
  MatrixXd result(M.rows(), M.cols() + count);
  result << M.leftCols(at), MatrixXd::Zero(M.rows(), count), M.rightCols(M.cols() - at);
  return result;
}

// The first `count` of the further rows of the end are rows of X, and those at the start from which
// they come are starts. Landmarks that returned earlier pass earlier, so these are the first.
Segment with_first(const PassedSegment& segment, Index count) {
  const Segment& own = *segment.segment;
  if (count == 0) return own;
  const Index n = own.starts;
  const auto passing = static_cast<Index>(std::count_if(
      segment.from.begin(), segment.from.begin() + count, [](Index from) { return from >= 0; }));
  Segment result{.starts = n + passing,
                 .items = own.items,
                 .X = with_columns(stacked(own.X, segment.more.topRows(count)), n, passing),
                 .G = with_columns(own.G, n, passing),
                 .g = VectorXd::Zero(own.g.size() + passing),
                 .length = own.length};
  for (Index i = 0; i < count; ++i) {
    const Index from = segment.from[static_cast<std::size_t>(i)];
    if (from >= 0) result.X(own.X.rows() + i, n + from) = 1;
  }
  result.G = with_columns(result.G.transpose(), n, passing);
  result.g.head(n) = own.g.head(n);
  result.g.tail(own.g.size() - n) = own.g.tail(own.g.size() - n);
  return result;
}

}  // namespace

void carry(Carried& past, const PassedSegment& segment, const std::vector<int>& numbers) {
  const Index n = segment.segment->starts, r = past.rows(), more = segment.more.rows();
  const MatrixXd before = std::move(past.C);
  if (r > 0) past.C = before.leftCols(n);
  carry(past, *segment.segment, numbers);
  if (more == 0) return;
  MatrixXd C(past.rows(), segment.rows());
  C.leftCols(past.C.cols()) = past.C;
  if (r > 0) {
    const MatrixXd by_starts = segment.more.leftCols(n).transpose();
    dense::multiply(before.leftCols(n), by_starts, C.topRightCorner(r, more));
    for (Index i = 0; i < more; ++i) {
      const Index from = segment.from[static_cast<std::size_t>(i)];
      if (from >= 0) C.col(C.cols() - more + i).head(r) += before.col(n + from);
    }
  }
  const std::vector<Index> items = variables_of(*segment.segment, numbers);
  C.bottomRightCorner(past.rows() - r, more) = segment.more(Eigen::all, items).transpose();
  past.C = std::move(C);
}

PassedSegment with_returned(const PassedSegment& segment, const Carried& past,
                            const std::vector<int>& numbers) {
  const Segment& own = *segment.segment;
  const std::vector<Index> items = variables_of(own, numbers);
  const Index r = past.rows(), k = static_cast<Index>(items.size()), n = own.starts;
  if (r + k == 0) return segment;
  MatrixXd returned(r + k, own.g.size());
  if (r > 0) {
    dense::multiply(past.C.leftCols(n), own.G.topRows(n), returned.topRows(r));
  }
  returned.bottomRows(k) = own.G(items, Eigen::all);
  PassedSegment result{
      .segment = segment.segment, .more = stacked(segment.more, returned), .from = segment.from};
  for (Index i = 0; i < r; ++i) result.from.push_back(past.C.cols() - n + i);
  result.from.resize(result.from.size() + items.size(), -1);
  return result;
}

// A row that returned after the younger one began passes through it, and has a row of the older one
// to add to.
PassedSegment compose(const PassedSegment& older, const PassedSegment& younger) {
  const Index first = younger.segment->starts - older.segment->X.rows();
  const Segment before = with_first(older, first);
  const Index n = before.starts, passing = n - older.segment->starts;
  const Index starts = younger.segment->starts, more = younger.more.rows();
  PassedSegment result{
      .segment = std::make_shared<const Segment>(compose(before, *younger.segment)),
      .more = MatrixXd(more, before.g.size() + younger.more.cols() - starts),
      .from = younger.from};
  result.more << dense::product(younger.more.leftCols(starts), before.X),
      younger.more.rightCols(younger.more.cols() - starts);
  const MatrixXd passed = with_columns(older.more.bottomRows(older.more.rows() - first),
                                       older.segment->starts, passing);
  for (Index i = 0; i < more; ++i) {
    Index& from = result.from[static_cast<std::size_t>(i)];
    if (from < 0) continue;
    result.more.row(i).head(passed.cols()) += passed.row(from);
    from = older.from[static_cast<std::size_t>(first + from)];
    if (from >= 0) from -= passing;
  }
  return result;
}

PassedSegment with_items(const PassedSegment& segment, const std::vector<int>& numbers) {
  std::vector<Index> variables(static_cast<std::size_t>(segment.segment->starts));
  std::iota(variables.begin(), variables.end(), Index{0});
  const std::vector<Index> items = variables_of(*segment.segment, numbers);
  variables.insert(variables.end(), items.begin(), items.end());
  return {.segment = std::make_shared<const Segment>(with_items(*segment.segment, numbers)),
          .more = segment.more(Eigen::all, variables),
          .from = segment.from};
}

PassedSegment with_derived(const PassedSegment& segment, int source,
                           const std::vector<DerivedItem>& derived) {
  Segment all = *segment.segment;
  const Index rows = all.X.rows();
  all.X = stacked(all.X, segment.more);
  all = with_derived(all, source, derived);
  PassedSegment result{
      .segment = {}, .more = all.X.bottomRows(segment.more.rows()), .from = segment.from};
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
  return {.segment = std::make_shared<const Segment>(std::move(rest)),
          .more = segment.more.rightCols(q),
          .from = std::vector<Index>(segment.from.size(), -1)};
}

Segment whole(const PassedSegment& segment) { return with_first(segment, segment.more.rows()); }

}  // namespace chasles
