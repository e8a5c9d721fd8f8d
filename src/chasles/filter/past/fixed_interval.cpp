#include <algorithm>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/connections.hpp>
#include <chasles/filter/past/fixed_interval.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What later measurements do to errors o with the cross-covariance C with the rows of the state and
// with the landmarks that have left and return later: correction C g, change of the covariance
// C G C^T.
struct Later {
  MatrixXd of_state, by_places, of_places;  // blocks of G
  VectorXd g, g_places;
};

Later without_measurements(Index rows, Index places) {
  return {.of_state = MatrixXd::Zero(rows, rows),
          .by_places = MatrixXd::Zero(places, rows),
          .of_places = MatrixXd::Zero(places, places),
          .g = VectorXd::Zero(rows),
          .g_places = VectorXd::Zero(places)};
}

// To so many places as they were before they were numbered anew. Those that were given up then had
// returned: no later measurement concerns them but through the state.
void renumber(const std::vector<Index>& before, Index places, Later& later) {
  const auto kept = static_cast<Index>(before.size());
  Later result = without_measurements(0, places);
  result.of_places(before, before) = later.of_places.topLeftCorner(kept, kept);
  result.g_places(before) = later.g_places.head(kept);
  result.by_places = MatrixXd::Zero(places, later.g.size());
  result.by_places(before, Eigen::all) = later.by_places.topRows(kept);
  later.by_places = std::move(result.by_places);
  later.of_places = std::move(result.of_places);
  later.g_places = std::move(result.g_places);
}

// What returned at the start of a segment is at its place.
void put_at_places(const std::vector<Index>& places, Later& later) {
  const auto m = static_cast<Index>(places.size()), n = later.g.size() - m;
  if (m == 0) return;
  later.of_places(Eigen::all, places) = later.by_places.rightCols(m);
  later.of_places(places, Eigen::all) = later.by_places.rightCols(m).transpose();
  later.of_places(places, places) = later.of_state.bottomRightCorner(m, m);
  later.by_places(places, Eigen::all) = later.of_state.bottomRows(m);
  later.g_places(places) = later.g.tail(m);
  later.by_places = later.by_places.leftCols(n).eval();
  later.of_state = later.of_state.topLeftCorner(n, n).eval();
  later.g = later.g.head(n).eval();
}

// The same of [rows of the state, columns of U, landmarks that leave in the segment], of which all
// that left by then is a linear function.
struct Reduced {
  MatrixXd by_places;  // of those that have left before
  MatrixXd G;
  VectorXd g;
};

Reduced reduced(const Later& later, const Connection& connection, Index leaving) {
  const Index rows = later.g.size(), d = connection.left, r = connection.K.rows();
  const MatrixXd U = connection.U(), U_transposed = U.transpose();
  Reduced result{.by_places = MatrixXd(d, rows + r + leaving),
                 .G = MatrixXd(rows + r + leaving, rows + r + leaving),
                 .g = VectorXd(rows + r + leaving)};
  result.by_places.leftCols(rows) = later.by_places.topRows(d);
  if (d > 0) {
    dense::multiply(later.of_places.topLeftCorner(d, d), U, result.by_places.middleCols(rows, r));
  }
  result.by_places.rightCols(leaving) = later.of_places.block(0, d, d, leaving);
  result.G.topLeftCorner(rows, rows) = later.of_state;
  result.G.bottomLeftCorner(leaving, rows) = later.by_places.middleRows(d, leaving);
  result.G.topRightCorner(rows, leaving) = later.by_places.middleRows(d, leaving).transpose();
  result.G.bottomRightCorner(leaving, leaving) = later.of_places.block(d, d, leaving, leaving);
  if (r > 0) {
    const MatrixXd by_U = dense::product(U_transposed, result.by_places);
    result.G.middleRows(rows, r) = by_U;
    result.G.middleCols(rows, r) = by_U.transpose();
    const auto square = by_U.middleCols(rows, r);
    result.G.block(rows, rows, r, r) = (square + square.transpose()) / 2;
  }
  result.g << later.g, U_transposed * later.g_places.head(d), later.g_places.segment(d, leaving);
  return result;
}

// The segment's own items, given all.
std::vector<SmoothedState> smoothed_items(const Segment& segment, const MatrixXd& by_end,
                                          const Reduced& later) {
  const MatrixXd gain = dense::product(by_end, later.G);
  std::vector<SmoothedState> result;
  Index row = 0;
  for (const Segment::Item& item : segment.items) {
    const Index at = segment.starts + row;
    const auto C = by_end.middleRows(row, item.size);
    result.push_back(
        without_rounding({.number = item.number,
                          .correction = segment.g.segment(at, item.size) + C * later.g,
                          .covariance = segment.G.block(at, at, item.size, item.size) +
                                        gain.middleRows(row, item.size) * C.transpose()}));
    row += item.size;
  }
  return result;
}

// From the end of a segment to its start.
std::vector<SmoothedState> go_back(const Segment& segment, const Connection& connection,
                                   const std::vector<int>& returning, Later& later) {
  const Index n = segment.starts, q = segment.g.size(), rows = segment.X.rows();
  const Index d = connection.left, r = connection.K.rows();
  const std::vector<Index> leaving = variables_of(segment, returning);
  const auto l = static_cast<Index>(leaving.size());
  const Reduced reduced_later = reduced(later, connection, l);
  // All that the segment knows of the end, by its variables.
  MatrixXd M(rows + r + l, q);
  M.topRows(rows) = segment.X;
  if (r > 0) dense::multiply(connection.K, segment.G.topRows(n), M.middleRows(rows, r));
  M.bottomRows(l) = segment.G(leaving, Eigen::all);
  std::vector<SmoothedState> items =
      smoothed_items(segment, M.rightCols(q - n).transpose(), reduced_later);
  const MatrixXd by_starts = M.leftCols(n), by_starts_transposed = by_starts.transpose();
  const MatrixXd G =
      dense::product(by_starts_transposed, dense::product(reduced_later.G, by_starts));
  later.of_state = (G + G.transpose()) / 2 + segment.G.topLeftCorner(n, n);
  later.g = by_starts_transposed * reduced_later.g + segment.g.head(n);
  later.by_places = MatrixXd::Zero(later.by_places.rows(), n);
  if (d > 0) {
    dense::multiply(reduced_later.by_places, by_starts, later.by_places.topRows(d));
  }
  later.of_places.middleRows(d, l).setZero();
  later.of_places.middleCols(d, l).setZero();
  later.g_places.segment(d, l).setZero();
  return items;
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
  if (stretches.empty()) return {};
  const std::vector<int> returning = returning_numbers(stretches);
  std::vector<Connection> connections = connections_of(stretches);
  Later later =
      without_measurements(stretches.back().segment->X.rows(), connections.back().places());
  std::vector<SmoothedState> result;
  while (!connections.empty()) {
    const Stretch& stretch = stretches[connections.size() - 1];
    const Connection connection = std::move(connections.back());
    connections.pop_back();
    const std::vector<SmoothedState> items =
        go_back(*stretch.segment, connection, returning, later);
    result.insert(result.end(), items.rbegin(), items.rend());
    if (connections.empty()) break;
    if (connection.before) renumber(*connection.before, connections.back().places(), later);
    put_at_places(connection.returned, later);
  }
  std::ranges::reverse(result);
  return result;
}

}  // namespace chasles
