#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/QR>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/connections.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kLandmark = 3;  // rows

class Connections {
 public:
  explicit Connections(std::vector<int> returning) : returning_(std::move(returning)) {}

  Connection at_start(const Stretch& stretch);
  void go_through(const Segment& segment);

 private:
  std::vector<Index> places_of(const std::vector<int>& numbers) const;
  std::vector<Index> give_up_returned();
  void make_room(const std::vector<Index>& kept, Index columns);
  void add_columns(const MatrixXd& columns);
  void note_change(const MatrixXd& change);
  MatrixXd covariance(const std::vector<Index>& rows, const std::vector<Index>& columns) const;

  std::vector<int> returning_;
  std::vector<int> numbers_;  // that have places, rising
  std::set<int> returned_;    // of those
  MatrixXd P_;                // covariance of those with places, but for U change_ U^T
  MatrixXd change_;           // of the first columns
  std::shared_ptr<MatrixXd> U_ = std::make_shared<MatrixXd>();
  MatrixXd K_;  // of the end
  Index left_ = 0;
};

std::vector<Index> Connections::places_of(const std::vector<int>& numbers) const {
  std::vector<Index> places;
  for (const int number : numbers) {
    const Index at = std::ranges::lower_bound(numbers_, number) - numbers_.begin();
    for (Index i = 0; i < kLandmark; ++i) places.push_back(kLandmark * at + i);
  }
  return places;
}

Connection Connections::at_start(const Stretch& stretch) {
  const std::vector<Index> now = places_of(*stretch.revived);
  const auto m = static_cast<Index>(now.size());
  const auto l = static_cast<Index>(variables_of(*stretch.segment, returning_).size());
  std::vector<Index> all(static_cast<std::size_t>(left_));
  std::iota(all.begin(), all.end(), Index{0});
  MatrixXd columns = covariance(all, now);
  returned_.insert(stretch.revived->begin(), stretch.revived->end());
  std::optional<std::vector<Index>> before;
  if (K_.rows() + m + l > U_->cols()) {
    before = give_up_returned();
    columns = columns(*before, Eigen::all).eval();
    make_room(*before, m + l);
  }
  if (m > 0) {
    const Index r = K_.rows(),
                further = left_ > 0 ? m : 0;  // nothing is away: no direction is needed
    if (further > 0) add_columns(columns);
    MatrixXd K = MatrixXd::Zero(r + further, K_.cols() + m);
    K.topLeftCorner(r, K_.cols()) = K_;
    K.bottomRightCorner(further, further).setIdentity();
    K_ = std::move(K);
  }
  return {.U_and_more = U_, .left = left_, .K = K_, .returned = now, .before = std::move(before)};
}

void Connections::go_through(const Segment& segment) {
  const std::vector<Index> leaving = variables_of(segment, returning_);
  const auto l = static_cast<Index>(leaving.size());
  const Index n = segment.starts, r = K_.rows(), before = left_;
  MatrixXd K(r + l, segment.X.rows());
  if (r > 0) {
    const auto U = U_->topLeftCorner(before, r);
    const MatrixXd by_G = dense::product(K_, segment.G.topRows(n));
    const MatrixXd K_transposed = K_.transpose(), by_start = segment.X.leftCols(n).transpose();
    note_change(dense::product(by_G.leftCols(n), K_transposed));
    P_.block(0, before, before, l) = U * by_G(Eigen::all, leaving);
    P_.block(before, 0, l, before) = P_.block(0, before, before, l).transpose();
    dense::multiply(K_, by_start, K.topRows(r));
  }
  P_.block(before, before, l, l) = segment.G(leaving, leaving);
  K.bottomRows(l) = segment.X(Eigen::all, leaving).transpose();
  for (const Segment::Item& item : segment.items) {
    if (std::ranges::binary_search(returning_, item.number)) numbers_.push_back(item.number);
  }
  left_ += l;
  MatrixXd own = MatrixXd::Zero(left_, l);
  own.bottomRows(l).setIdentity();
  add_columns(own);
  K_ = std::move(K);
}

// Columns that no earlier segment has in its U.
void Connections::add_columns(const MatrixXd& columns) {
  U_->block(0, K_.rows(), columns.rows(), columns.cols()) = columns;
}

// A segment changes the covariance by U change U^T. That waits until the covariance is asked for.
void Connections::note_change(const MatrixXd& change) {
  const Index before = change_.rows();
  MatrixXd sum = change;
  sum.topLeftCorner(before, before) += change_;
  change_ = std::move(sum);
}

MatrixXd Connections::covariance(const std::vector<Index>& rows,
                                 const std::vector<Index>& columns) const {
  MatrixXd P = P_(rows, columns);
  const Index r = change_.rows();
  if (r == 0 || columns.empty()) return P;
  const MatrixXd U = (*U_)(rows, Eigen::seqN(0, r));
  const MatrixXd of_columns = (*U_)(columns, Eigen::seqN(0, r)).transpose();
  dense::add_product(1, U, dense::product(change_, of_columns), P);
  return P;
}

// The places of the others.
std::vector<Index> Connections::give_up_returned() {
  std::vector<int> others;
  std::ranges::set_difference(numbers_, returned_, std::back_inserter(others));
  std::vector<Index> places = places_of(others);
  numbers_ = std::move(others);
  returned_.clear();
  return places;
}

void Connections::make_room(const std::vector<Index>& kept, Index columns) {
  constexpr Index kRoom = 30;
  constexpr double kExplained = 1e-8;
  const auto rows = static_cast<Index>(kept.size());
  MatrixXd U(rows, 0);
  const MatrixXd before = (*U_)(kept, Eigen::seqN(0, K_.rows()));
  const MatrixXd P_of_kept = covariance(kept, kept);
  if (rows <= K_.rows()) {
    K_ = dense::product(before, K_);
    U = MatrixXd::Identity(rows, rows);
  } else if (K_.rows() > 0) {
    const Eigen::VectorXd scale = K_.cwiseAbs().colwise().maxCoeff().transpose().cwiseMax(1e-100);
    Eigen::ColPivHouseholderQR<MatrixXd> qr;
    qr.setThreshold(kExplained);
    qr.compute(scale.cwiseInverse().asDiagonal() * K_.transpose());
    const Index rank = qr.rank();
    MatrixXd R = qr.matrixR().topRows(rank);
    R.triangularView<Eigen::StrictlyLower>().setZero();
    const MatrixXd of_kept = qr.colsPermutation() * R.transpose();
    const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(K_.cols(), rank);
    U = dense::product(before, of_kept);
    K_ = Q.transpose() * scale.asDiagonal();
  }
  const Index room = std::max(kRoom, 2 * columns);  // segments that share a U save its memory
  U_ = std::make_shared<MatrixXd>(MatrixXd::Zero(rows + room, U.cols() + room));
  U_->topLeftCorner(rows, U.cols()) = U;
  MatrixXd P = MatrixXd::Zero(rows + room, rows + room);
  P.topLeftCorner(rows, rows) = P_of_kept;
  change_.resize(0, 0);
  P_ = std::move(P);
  left_ = rows;
}

}  // namespace

std::vector<int> returning_numbers(const std::vector<Stretch>& stretches) {
  std::vector<int> numbers;
  for (const Stretch& one : stretches) {
    numbers.insert(numbers.end(), one.revived->begin(), one.revived->end());
  }
  std::ranges::sort(numbers);
  return numbers;
}

std::vector<Connection> connections_of(const std::vector<Stretch>& stretches) {
  Connections forwards(returning_numbers(stretches));
  std::vector<Connection> connections;
  for (const Stretch& stretch : stretches) {
    connections.push_back(forwards.at_start(stretch));
    forwards.go_through(*stretch.segment);
  }
  return connections;
}

}  // namespace chasles
