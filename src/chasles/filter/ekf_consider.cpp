#include <algorithm>
#include <utility>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>

// A map and rows of the core that no update changes: the Schmidt-Kalman filter (docs/filter.md).

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

int Ekf::consider(PriorMap prior) {
  if (state_.considered) throw UsageError("a filter considers one map, and has one already");
  const auto r = static_cast<int>(prior.shared.cols());
  const int frame = past_.consider(std::move(prior));
  const int row = covariance_.append(r);
  covariance_.all().block(row, row, r, r).setIdentity();
  state_.considered = ConsideredMap{.frame = frame, .row = row, .mean = VectorXd::Zero(r)};
  return frame;
}

void Ekf::leave_unused(const Whitened& z, Eigen::Ref<VectorXd> delta) {
  const UnusedGain unused = unused_gain(state_, past_.left(), z);
  const MatrixXd D_transposed = unused.D.transpose();
  const MatrixXd more = dense::product(unused.D, D_transposed);
  auto P = covariance_.all();
  for (std::size_t j = 0; j < unused.rows.size(); ++j) {
    for (std::size_t i = 0; i < unused.rows.size(); ++i) {
      if (unused.rows[i] < unused.rows[j]) continue;
      P(unused.rows[i], unused.rows[j]) += more(static_cast<Index>(i), static_cast<Index>(j));
    }
  }
  for (std::size_t i = 0; i < unused.rows.size(); ++i) {
    for (const int other : considered_) {
      const auto [column, row] = std::minmax(unused.rows[i], other);
      P(row, column) += unused.D.row(static_cast<Index>(i)).dot(z.W.row(other));
    }
  }
  delta(unused.rows) -= unused.D * z.w;
}

// Without a gain, what the update would have taken from their own covariance stays.
void Ekf::leave_considered(const Whitened& z, Eigen::Ref<VectorXd> delta) {
  auto P = covariance_.all();
  for (const int column : considered_) {
    for (const int row : considered_) {
      if (row >= column) P(row, column) += z.W.row(row).dot(z.W.row(column));
    }
    delta[column] = 0;
  }
}

// Their rows are copied to the end of the error vector, or follow from the shared errors.
void Ekf::revive_considered(const std::vector<int>& numbers) {
  ConsideredMap& map = *state_.considered;
  const Index n = covariance_.size();
  const OfState of_state = considered_of_state(state_, past_.left(), numbers, n);
  const Index k = of_state.d.rows();
  const MatrixXd d_transposed = of_state.d.transpose();
  const MatrixXd C = dense::product(of_state.d, covariance_.all());
  const int row = covariance_.append(static_cast<int>(k));
  auto P = covariance_.all();
  P.block(row, 0, k, n) = C;
  P.block(0, row, n, k) = C.transpose();
  P.bottomRightCorner(k, k) = dense::product(C, d_transposed) + of_state.own;
  past_.append_function(d_transposed);
  std::vector<Vector3d> as_they_left;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Landmark landmark = past_.left().landmark(numbers[i]);
    const auto away = std::ranges::find(map.away, std::optional(numbers[i]), &Landmark::considered);
    if (away != map.away.end()) {
      landmark = *away;
      map.away.erase(away);
    }
    as_they_left.push_back(landmark.p_world);
    landmark.considered = numbers[i];
    landmark.row = row + 3 * static_cast<int>(i);
    landmark.p_world = considered_place(state_, past_.left(), numbers[i]);
    state_.landmarks.push_back(landmark);
  }
  keep_rows();
  past_.note_returned(numbers);
  follow_the_changes(as_they_left);
}

// The rows of a considered landmark are given up where it was in the state.
void Ekf::bar_return(std::span<const int> numbers) {
  for (const int number : numbers) past_.bar_return(number);
  if (!state_.considered) return;
  for (const int number : numbers) {
    const auto gone = std::erase_if(state_.considered->away,
                                    [&](const Landmark& l) { return l.considered == number; });
    if (gone > 0) keep_rows();
  }
}

}  // namespace chasles
