#include <algorithm>
#include <optional>
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

// The same from the end of a segment back through all that have the same U. Between two returns,
// all that left is a linear function of the state and of the columns of U, to which a segment adds
// one for each row that leaves in it. So a segment needs U^T G U alone, and its cost does not grow
// with the places. What it changes in their rows waits in two factors:
//
//   by_places = places before * state + (of_places U) * columns
class LaterByColumns {
 public:
  // `leaving`: rows that leave in the segment.
  LaterByColumns(Later later, const Connection& connection, Index leaving)
      : later_(std::move(later)) {
    const Index rows = connection.left + leaving, columns = connection.K.rows() + leaving;
    const MatrixXd U = connection.U_and_more->topLeftCorner(rows, columns);
    const MatrixXd U_transposed = U.transpose();
    of_places_U_ = dense::product(later_.of_places.topLeftCorner(rows, rows), U);
    of_columns_ = dense::product(U_transposed, of_places_U_);
    of_columns_ = (of_columns_ + of_columns_.transpose()) / 2;
    by_columns_ = dense::product(U_transposed, later_.by_places.topRows(rows));
    g_columns_ = U_transposed * later_.g_places.head(rows);
    state_ = MatrixXd::Identity(later_.g.size(), later_.g.size());
    columns_ = MatrixXd::Zero(columns, later_.g.size());
  }

  // Of [rows of the state, the first columns of U].
  MatrixXd G(Index columns) const {
    const Index rows = later_.g.size();
    MatrixXd G(rows + columns, rows + columns);
    G.topLeftCorner(rows, rows) = later_.of_state;
    G.bottomLeftCorner(columns, rows) = by_columns_.topRows(columns);
    G.topRightCorner(rows, columns) = by_columns_.topRows(columns).transpose();
    G.bottomRightCorner(columns, columns) = of_columns_.topLeftCorner(columns, columns);
    return G;
  }
  VectorXd g(Index columns) const {
    VectorXd g(later_.g.size() + columns);
    g << later_.g, g_columns_.head(columns);
    return g;
  }

  // To the start of a segment, where U has `left` columns: `by_starts` has what the segment knows
  // of its end and of the columns, by its starts.
  void go_back(const Segment& segment, const MatrixXd& by_starts, Index left) {
    const Index n = segment.starts, rows = later_.g.size(), columns = by_starts.rows() - rows;
    const MatrixXd G = this->G(columns), transposed = by_starts.transpose();
    MatrixXd of_state = MatrixXd::Zero(n, n);
    dense::add_product_lower(transposed, dense::product(G, by_starts), of_state);
    dense::mirror_lower(of_state);
    later_.of_state = of_state + segment.G.topLeftCorner(n, n);
    later_.g = transposed * g(columns) + segment.g.head(n);
    by_columns_ = dense::product(G.middleRows(rows, left), by_starts);
    const MatrixXd by_state = by_starts.topRows(rows);
    MatrixXd waiting = dense::product(columns_, by_state);
    waiting.topRows(columns) += by_starts.bottomRows(columns);
    columns_ = std::move(waiting);
    state_ = dense::product(state_, by_state);
  }

  // With the rows of the places; what has left since is no longer there.
  Later of_places(Index left) && {
    const Index after = later_.g_places.size() - left;
    MatrixXd by_places = MatrixXd::Zero(later_.g_places.size(), later_.g.size());
    if (left > 0) {
      dense::multiply(later_.by_places.topRows(left), state_, by_places.topRows(left));
      dense::add_product(1, of_places_U_.topRows(left), columns_, by_places.topRows(left));
    }
    later_.by_places = std::move(by_places);
    later_.of_places.bottomRows(after).setZero();
    later_.of_places.rightCols(after).setZero();
    later_.g_places.tail(after).setZero();
    return std::move(later_);
  }

 private:
  Later later_;  // its places as they were at first
  MatrixXd of_places_U_, of_columns_, by_columns_;
  VectorXd g_columns_;
  MatrixXd state_, columns_;
};

// The segment's own items, given all.
std::vector<SmoothedState> smoothed_items(const Segment& segment, const MatrixXd& by_end,
                                          const MatrixXd& G, const VectorXd& g) {
  const MatrixXd gain = dense::product(by_end, G);
  std::vector<SmoothedState> result;
  Index row = 0;
  for (const Segment::Item& item : segment.items) {
    const Index at = segment.starts + row;
    const auto C = by_end.middleRows(row, item.size);
    result.push_back(
        without_rounding({.number = item.number,
                          .correction = segment.g.segment(at, item.size) + C * g,
                          .covariance = segment.G.block(at, at, item.size, item.size) +
                                        gain.middleRows(row, item.size) * C.transpose()}));
    row += item.size;
  }
  return result;
}

// From the end of a segment to its start.
std::vector<SmoothedState> go_back(const Segment& segment, const Connection& connection,
                                   const std::vector<Index>& leaving, LaterByColumns& later) {
  const Index n = segment.starts, q = segment.g.size(), rows = segment.X.rows();
  const Index r = connection.K.rows(), l = static_cast<Index>(leaving.size());
  // All that the segment knows of the end and of the columns, by its variables.
  MatrixXd M(rows + r + l, q);
  M.topRows(rows) = segment.X;
  if (r > 0) dense::multiply(connection.K, segment.G.topRows(n), M.middleRows(rows, r));
  M.bottomRows(l) = segment.G(leaving, Eigen::all);
  std::vector<SmoothedState> items =
      smoothed_items(segment, M.rightCols(q - n).transpose(), later.G(r + l), later.g(r + l));
  later.go_back(segment, M.leftCols(n), r);
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
  std::optional<LaterByColumns> by_columns;
  std::vector<SmoothedState> result;
  while (!connections.empty()) {
    const Stretch& stretch = stretches[connections.size() - 1];
    const Connection connection = std::move(connections.back());
    connections.pop_back();
    const std::vector<Index> leaving = variables_of(*stretch.segment, returning);
    if (!by_columns) {
      by_columns.emplace(std::move(later), connection, static_cast<Index>(leaving.size()));
    }
    const std::vector<SmoothedState> items =
        go_back(*stretch.segment, connection, leaving, *by_columns);
    result.insert(result.end(), items.rbegin(), items.rend());
    if (connections.empty()) break;
    if (!connection.before && connection.returned.empty()) continue;  // the same U
    later = std::move(*by_columns).of_places(connection.left);
    by_columns.reset();
    if (connection.before) renumber(*connection.before, connections.back().places(), later);
    put_at_places(connection.returned, later);
  }
  std::ranges::reverse(result);
  return result;
}

}  // namespace chasles
