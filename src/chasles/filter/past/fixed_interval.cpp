#include <algorithm>
#include <memory>
#include <utility>

#include <Eigen/QR>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/fixed_interval.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kLandmark = 3;  // rows

// The landmarks that return have places by the order of their numbers. They leave in that order, so
// those that have left by some time are the first.
class Places {
 public:
  explicit Places(const std::vector<Stretch>& stretches) {
    for (const Stretch& one : stretches) {
      numbers_.insert(numbers_.end(), one.revived->begin(), one.revived->end());
    }
    std::ranges::sort(numbers_);
  }
  const std::vector<int>& numbers() const { return numbers_; }
  Index rows() const { return kLandmark * static_cast<Index>(numbers_.size()); }
  std::vector<Index> of(const std::vector<int>& numbers) const {
    std::vector<Index> rows;
    for (const int number : numbers) {
      const Index place = std::ranges::lower_bound(numbers_, number) - numbers_.begin();
      for (Index i = 0; i < kLandmark; ++i) rows.push_back(kLandmark * place + i);
    }
    return rows;
  }

 private:
  std::vector<int> numbers_;
};

// At the start of a segment: the cross-covariance U K of the landmarks that return, as far as they
// have left, with its starts. Few directions of the state connect it with what left long before, so
// U has few columns. The rows of those that have returned already are of no use.
struct Connection {
  std::shared_ptr<const MatrixXd> U_and_more;  // shared by successive segments
  Index left = 0;                              // rows of U
  MatrixXd K;

  auto U() const { return U_and_more->topLeftCorner(left, K.rows()); }
};

// Forwards through the segments.
class Connections {
 public:
  explicit Connections(const Places& places)
      : places_(places),
        P_(MatrixXd::Zero(places.rows(), places.rows())),
        U_(std::make_shared<MatrixXd>(places.rows(), 0)) {}

  Connection at_start(const Stretch& stretch) {
    const std::vector<Index> now = places_.of(*stretch.revived);
    const auto m = static_cast<Index>(now.size());
    if (m > 0) {
      make_room(m);
      const Index r = K_.rows();
      add_columns(P_(Eigen::seqN(0, left_), now));
      MatrixXd K = MatrixXd::Zero(r + m, K_.cols() + m);
      K.topLeftCorner(r, K_.cols()) = K_;
      K.bottomRightCorner(m, m).setIdentity();
      K_ = std::move(K);
    }
    return {.U_and_more = U_, .left = left_, .K = K_};
  }

  void go_through(const Segment& segment) {
    const std::vector<Index> leaving = variables_of(segment, places_.numbers());
    const auto l = static_cast<Index>(leaving.size());
    make_room(l);
    const Index n = segment.starts, r = K_.rows(), before = left_;
    MatrixXd K(r + l, segment.X.rows());
    if (r > 0) {
      const MatrixXd U = U_->topLeftCorner(before, r), U_transposed = U.transpose();
      const MatrixXd by_G = dense::product(K_, segment.G.topRows(n));
      const MatrixXd K_transposed = K_.transpose(), by_start = segment.X.leftCols(n).transpose();
      const MatrixXd change = dense::product(by_G.leftCols(n), K_transposed);
      dense::add_product(1, dense::product(U, change), U_transposed,
                         P_.topLeftCorner(before, before));
      P_.block(0, before, before, l) = U * by_G(Eigen::all, leaving);
      P_.block(before, 0, l, before) = P_.block(0, before, before, l).transpose();
      dense::multiply(K_, by_start, K.topRows(r));
    }
    P_.block(before, before, l, l) = segment.G(leaving, leaving);
    K.bottomRows(l) = segment.X(Eigen::all, leaving).transpose();
    left_ += l;
    MatrixXd own = MatrixXd::Zero(left_, l);
    own.bottomRows(l).setIdentity();
    add_columns(own);
    K_ = std::move(K);
  }

 private:
  // Columns that no earlier segment has in its U.
  void add_columns(const MatrixXd& columns) {
    U_->block(0, K_.rows(), columns.rows(), columns.cols()) = columns;
  }

  // Directions of the state that the others explain to 1e-12 are left out.
  void make_room(Index columns) {
    constexpr double kExplained = 1e-12;
    constexpr Index kRoom = 60;
    if (K_.rows() + columns <= U_->cols()) return;
    MatrixXd U(left_, 0);
    if (K_.rows() > 0) {
      const Eigen::VectorXd scale = K_.cwiseAbs().colwise().maxCoeff().transpose().cwiseMax(1e-100);
      Eigen::ColPivHouseholderQR<MatrixXd> qr;
      qr.setThreshold(kExplained);
      qr.compute(scale.cwiseInverse().asDiagonal() * K_.transpose());
      const Index rank = qr.rank();
      MatrixXd R = qr.matrixR().topRows(rank);
      R.triangularView<Eigen::StrictlyLower>().setZero();
      const MatrixXd of_kept = qr.colsPermutation() * R.transpose();
      const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(K_.cols(), rank);
      U = dense::product(U_->topLeftCorner(left_, K_.rows()), of_kept);
      K_ = Q.transpose() * scale.asDiagonal();
    }
    U_ = std::make_shared<MatrixXd>(
        MatrixXd::Zero(places_.rows(), U.cols() + std::max(kRoom, columns)));
    U_->topLeftCorner(left_, U.cols()) = U;
  }

  const Places& places_;
  MatrixXd P_;  // covariance of those that have left
  std::shared_ptr<MatrixXd> U_;
  MatrixXd K_;  // of the end
  Index left_ = 0;
};

// What later measurements do to errors o with the cross-covariance C with the rows of the state and
// with the landmarks that have left and return later: correction C g, change of the covariance
// C G C^T.
struct Later {
  MatrixXd of_state, by_places, of_places;  // blocks of G
  VectorXd g, g_places;
};

// From the start of a segment to the end of the one before: what returned there is at its place.
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
  const Places places(stretches);
  Connections forwards(places);
  std::vector<Connection> connections;
  for (const Stretch& stretch : stretches) {
    connections.push_back(forwards.at_start(stretch));
    forwards.go_through(*stretch.segment);
  }
  const Index end = stretches.back().segment->X.rows(), d = places.rows();
  Later later{.of_state = MatrixXd::Zero(end, end),
              .by_places = MatrixXd::Zero(d, end),
              .of_places = MatrixXd::Zero(d, d),
              .g = VectorXd::Zero(end),
              .g_places = VectorXd::Zero(d)};
  std::vector<SmoothedState> result;
  for (std::size_t i = stretches.size(); i-- > 0;) {
    const std::vector<SmoothedState> items =
        go_back(*stretches[i].segment, connections[i], places.numbers(), later);
    put_at_places(places.of(*stretches[i].revived), later);
    result.insert(result.end(), items.rbegin(), items.rend());
  }
  std::ranges::reverse(result);
  return result;
}

}  // namespace chasles
