#include <algorithm>
#include <numeric>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/fixed_interval.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What later measurements do to errors that have the cross-covariance C with some variables:
// correction C g, change of the covariance C G C^T.
struct Later {
  MatrixXd G;
  VectorXd g;
};

// The states that return later, where a segment begins: those that have already left.
struct ReturningStates {
  std::vector<Segment::Item> items;
  MatrixXd C;  // their cross-covariance with all starts of the segment
};

std::vector<int> sorted_numbers(const std::vector<Stretch>& stretches) {
  std::vector<int> numbers;
  for (const Stretch& one : stretches) {
    numbers.insert(numbers.end(), one.revived->begin(), one.revived->end());
  }
  std::ranges::sort(numbers);
  return numbers;
}

std::vector<Index> rows_of(const std::vector<Segment::Item>& items, const std::vector<int>& numbers,
                           bool listed) {
  std::vector<Index> rows;
  Index at = 0;
  for (const Segment::Item& item : items) {
    if ((std::ranges::find(numbers, item.number) != numbers.end()) == listed) {
      for (Index i = 0; i < item.size; ++i) rows.push_back(at + i);
    }
    at += item.size;
  }
  return rows;
}

// Forwards: the states that return later, at the beginning of every segment.
std::vector<ReturningStates> find_returning(const std::vector<Stretch>& stretches,
                                            const std::vector<int>& returning) {
  std::vector<ReturningStates> result;
  Carried past;
  for (const Stretch& stretch : stretches) {
    const Segment* segment = stretch.segment;
    const std::vector<int>* revived = stretch.revived;
    // Those that return now are starts of the segment. Their order in the list is that of `past`.
    const std::vector<Index> now = rows_of(past.items, *revived, true);
    const std::vector<Index> rest = rows_of(past.items, *revived, false);
    MatrixXd C(static_cast<Index>(rest.size()), segment->starts);
    if (!rest.empty()) C << past.C(rest, Eigen::all), past.P(rest, now);
    std::erase_if(past.items, [&](const Segment::Item& item) {
      return std::ranges::find(*revived, item.number) != revived->end();
    });
    past.P = past.P(rest, rest).eval();
    past.correction = past.correction(rest).eval();
    past.C = C;
    result.push_back({.items = past.items, .C = std::move(C)});
    carry(past, *segment, returning);
  }
  return result;
}

// Of the segment's items, those that return later.
std::vector<Index> returning_variables(const Segment& segment, const std::vector<int>& returning) {
  std::vector<Index> result;
  Index at = segment.starts;
  for (const Segment::Item& item : segment.items) {
    if (std::ranges::binary_search(returning, item.number)) {
      for (Index i = 0; i < item.size; ++i) result.push_back(at + i);
    }
    at += item.size;
  }
  return result;
}

// The later measurements' variables, from the beginning of the next segment [rows of the state,
// returned states, states that return later] to the end of this one [rows of the state, states that
// return later, in the order of numbers].
void reorder(Later& later, const Stretch& next, const ReturningStates& returning) {
  struct Place {
    int number = 0;
    Index row = 0, size = 0;
  };
  const Index n = next.segment->starts;
  std::vector<Place> places;
  Index at = n;
  for (const Segment::Item& item : returning.items) {
    places.push_back({item.number, at, item.size});
    at += item.size;
  }
  Index revived_at = n;
  for (auto number = next.revived->rbegin(); number != next.revived->rend(); ++number) {
    constexpr Index kLandmark = 3;
    revived_at -= kLandmark;
    places.push_back({*number, revived_at, kLandmark});
  }
  std::ranges::sort(places, {}, &Place::number);
  std::vector<Index> order(static_cast<std::size_t>(revived_at));
  std::iota(order.begin(), order.end(), Index{0});
  for (const Place& place : places) {
    for (Index i = 0; i < place.size; ++i) order.push_back(place.row + i);
  }
  later.G = later.G(order, order).eval();
  later.g = later.g(order).eval();
}

}  // namespace

SmoothedState without_rounding(SmoothedState state) {
  constexpr double kExact = 1e-20;  // (0.1 nm)^2
  for (Index i = 0; i < state.covariance.rows(); ++i) {
    if (state.covariance(i, i) > kExact) continue;
    state.covariance.row(i).setZero();
    state.covariance.col(i).setZero();
    state.correction(i) = 0;
  }
  return state;
}

std::vector<SmoothedState> smooth_segments(const std::vector<Stretch>& stretches) {
  const std::vector<int> returning = sorted_numbers(stretches);
  const std::vector<ReturningStates> returning_states = find_returning(stretches, returning);
  std::vector<SmoothedState> result;
  Later later;
  for (std::size_t i = stretches.size(); i-- > 0;) {
    const Segment& segment = *stretches[i].segment;
    const MatrixXd& C = returning_states[i].C;
    const Index n = segment.starts, own = segment.g.size() - n, d = C.rows();
    const std::vector<Index> leaving = returning_variables(segment, returning);
    const auto l = static_cast<Index>(leaving.size());
    const Index rows = segment.X.rows();
    if (i + 1 == stretches.size()) {
      later = {.G = MatrixXd::Zero(rows + d + l, rows + d + l), .g = VectorXd::Zero(rows + d + l)};
    } else {
      reorder(later, stretches[i + 1], returning_states[i + 1]);
    }
    // The end's rows by the starts, and the items' covariances with the end's rows. The states
    // that return later stay what they were.
    MatrixXd M(rows + d + l, n);
    M << segment.X.leftCols(n), dense::product(C, segment.G.topLeftCorner(n, n)),
        segment.G.leftCols(n)(leaving, Eigen::all);
    MatrixXd own_by_end(own, rows + d + l);
    own_by_end.leftCols(rows) = segment.X.rightCols(own).transpose();
    own_by_end.middleCols(rows, d) =
        dense::product(segment.G.bottomLeftCorner(own, n), MatrixXd(C.transpose()));
    own_by_end.rightCols(l) = segment.G.bottomRows(own)(Eigen::all, leaving);
    const MatrixXd gain = dense::product(own_by_end, later.G);
    Index at = 0;
    std::vector<SmoothedState> here;
    for (const Segment::Item& item : segment.items) {
      const auto C_item = own_by_end.middleRows(at, item.size);
      here.push_back(
          without_rounding({.number = item.number,
                            .correction = segment.g.segment(n + at, item.size) + C_item * later.g,
                            .covariance = segment.G.block(n + at, n + at, item.size, item.size) +
                                          gain.middleRows(at, item.size) * C_item.transpose()}));
      at += item.size;
    }
    result.insert(result.end(), here.rbegin(), here.rend());
    const MatrixXd from_starts = dense::product(later.G, M);
    const MatrixXd M_transposed = M.transpose();
    const MatrixXd of_starts = dense::product(M_transposed, from_starts);
    const VectorXd g = M_transposed * later.g;
    MatrixXd G(n + d, n + d);
    G.topLeftCorner(n, n) = (of_starts + of_starts.transpose()) / 2 + segment.G.topLeftCorner(n, n);
    G.bottomLeftCorner(d, n) = from_starts.middleRows(rows, d);
    G.topRightCorner(n, d) = G.bottomLeftCorner(d, n).transpose();
    G.bottomRightCorner(d, d) = later.G.block(rows, rows, d, d);
    VectorXd g_before(n + d);
    g_before << g + segment.g.head(n), later.g.segment(rows, d);
    later = {.G = std::move(G), .g = std::move(g_before)};
  }
  std::ranges::reverse(result);
  return result;
}

}  // namespace chasles
