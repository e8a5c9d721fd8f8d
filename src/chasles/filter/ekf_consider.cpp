#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/so3.hpp>

// A map that no update changes: the Schmidt-Kalman filter (docs/filter.md).

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

int Ekf::consider(PriorMap prior) {
  check_fits(prior);
  if (state_.considered) throw UsageError("a filter considers one map, and has one already");
  const auto r = static_cast<int>(prior.shared.cols());
  const int row = covariance_.append(r);
  covariance_.all().block(row, row, r, r).setIdentity();
  latest_.append_rows(r);
  const int frame = past_.add(std::move(prior));
  state_.considered = ConsideredMap{.frame = frame, .row = row, .mean = VectorXd::Zero(r)};
  return frame;
}

bool Ekf::is_considered(int number) const {
  if (!state_.considered) return false;
  const int frame = state_.considered->frame;
  return number == frame || past_.frame_of(number) == frame;
}

// The other numbers, and those of a considered map.
std::pair<std::vector<int>, std::vector<int>> Ekf::apart(std::span<const int> numbers) const {
  std::pair<std::vector<int>, std::vector<int>> result;
  for (const int number : numbers) {
    (is_considered(number) ? result.second : result.first).push_back(number);
  }
  return result;
}

// In the axes of the filter's map.
Vector3d Ekf::considered_place(const State& x, int number) const {
  const ConsideredMap& map = *x.considered;
  const PriorMap& prior = past_.prior(map.frame);
  const Index index = number - map.frame - 1;
  return prior.landmarks[static_cast<std::size_t>(index)].p_world +
         prior.shared.middleRows<3>(6 + 3 * index) * map.mean;
}

void Ekf::put_considered_in_place(State& x, const ErrorRef& delta) const {
  ConsideredMap& map = *x.considered;
  const Index of_frame = past_.prior(map.frame).of_frame;
  map.mean.tail(of_frame) += delta.segment(map.row + map.mean.size() - of_frame, of_frame);
  const SE3 world_T_map = x.nav_T_world ? x.nav_T_world->inverse() : SE3{};
  for (Landmark& landmark : x.landmarks) {
    if (!landmark.considered) continue;
    landmark.p_world = world_T_map * considered_place(x, *landmark.considered);
  }
}

// With the optimal gain W, P - W W^T. With the gain W - D, where D is W for what is considered and
// 0 for all else, P - W W^T + D D^T. The frame takes W, and the landmarks' rows contain the frame:
// their D is what remains of W without it. The covariances with all that D does not concern, past
// states among them, are those of W.
Ekf::Unused Ekf::unused_gain(const Whitened& z) const {
  const ConsideredMap& map = *state_.considered;
  const PriorMap& prior = past_.prior(map.frame);
  const Index of_frame = prior.of_frame, fixed = map.mean.size() - of_frame;
  std::vector<const Landmark*> landmarks;
  for (const Landmark& landmark : state_.landmarks) {
    if (landmark.considered) landmarks.push_back(&landmark);
  }
  const auto away = static_cast<std::ptrdiff_t>(landmarks.size());
  for (const Landmark& landmark : map.away) landmarks.push_back(&landmark);
  Unused unused;
  unused.rows.resize(static_cast<std::size_t>(fixed));
  std::iota(unused.rows.begin(), unused.rows.end(), map.row);
  unused.D.resize(fixed + 3 * std::ssize(landmarks), z.W.cols());
  unused.D.topRows(fixed) = z.W.middleRows(map.row, fixed);
  const auto W_frame = z.W.middleRows(map.row + fixed, of_frame);
  for (std::ptrdiff_t i = 0; i < std::ssize(landmarks); ++i) {
    const Landmark& landmark = *landmarks[static_cast<std::size_t>(i)];
    const Index index = *landmark.considered - map.frame - 1;
    Eigen::Matrix<double, 3, Eigen::Dynamic> by_frame =
        prior.shared.block(6 + 3 * index, fixed, 3, of_frame) * W_frame;
    if (i < away && state_.nav_T_world) {
      const SE3& nav_T_world = *state_.nav_T_world;
      const int nav = state_.nav_row();
      by_frame += hat(nav_T_world.R * landmark.p_world) * z.W.middleRows<3>(nav) -
                  z.W.middleRows<3>(nav + 3);
      by_frame = nav_T_world.R.transpose() * by_frame;
    }
    unused.D.middleRows<3>(fixed + 3 * i) = z.W.middleRows<3>(landmark.row) - by_frame;
    for (int k = 0; k < 3; ++k) unused.rows.push_back(landmark.row + k);
  }
  return unused;
}

void Ekf::leave_unused(const Whitened& z, Eigen::Ref<VectorXd> delta) {
  const Unused unused = unused_gain(z);
  const MatrixXd D_transposed = unused.D.transpose();
  const MatrixXd more = dense::product(unused.D, D_transposed);
  auto P = covariance_.all();
  for (std::size_t j = 0; j < unused.rows.size(); ++j) {
    for (std::size_t i = 0; i < unused.rows.size(); ++i) {
      if (unused.rows[i] < unused.rows[j]) continue;
      P(unused.rows[i], unused.rows[j]) += more(static_cast<Index>(i), static_cast<Index>(j));
    }
  }
  delta(unused.rows) -= unused.D * z.w;
}

Ekf::OfState Ekf::considered_of_state(std::span<const int> numbers) const {
  const ConsideredMap& map = *state_.considered;
  const PriorMap& prior = past_.prior(map.frame);
  const Index r = map.mean.size();
  OfState result;
  Index rows = 0;
  for (const int number : numbers) {
    const int size = number == map.frame ? static_cast<int>(r) : 3;
    result.items.push_back({.number = number, .size = size});
    rows += size;
  }
  result.d = MatrixXd::Zero(rows, covariance_.size());
  result.own = MatrixXd::Zero(rows, rows);
  result.correction.resize(rows);
  Index at = 0;
  for (const Segment::Item& item : result.items) {
    const int number = item.number;
    if (number == map.frame) {
      result.d.block(at, map.row, r, r).setIdentity();
      result.correction.segment(at, r) = map.mean;
    } else {
      const Index index = number - map.frame - 1;
      const auto away = std::ranges::find(map.away, std::optional(number), &Landmark::considered);
      if (away != map.away.end()) {
        result.d.block<3, 3>(at, away->row).setIdentity();
      } else {
        result.d.block(at, map.row, 3, r) = prior.shared.middleRows<3>(6 + 3 * index);
        result.own.block<3, 3>(at, at) = prior.own[static_cast<std::size_t>(index)];
      }
      result.correction.segment<3>(at) =
          considered_place(state_, number) - past_.landmark(number).p_world;
    }
    at += item.size;
  }
  return result;
}

// Together with other past states, in the order of their numbers.
Carried Ekf::recall_considered(std::span<const int> considered, const Carried& others) const {
  const OfState of_state = considered_of_state(considered);
  const Index n = covariance_.size(), k = others.rows(), m = of_state.d.rows();
  const MatrixXd P_state = covariance_.all(), d_transposed = of_state.d.transpose();
  MatrixXd C(k + m, n), P(k + m, k + m);
  VectorXd correction(k + m);
  if (k > 0) C.topRows(k) = others.C;
  C.bottomRows(m) = dense::product(of_state.d, P_state);
  P.topLeftCorner(k, k) = others.P;
  P.rightCols(m) = dense::product(C, d_transposed);
  P.bottomLeftCorner(m, k) = P.topRightCorner(k, m).transpose();
  P.bottomRightCorner(m, m) += of_state.own;
  correction << others.correction, of_state.correction;

  struct Place {
    Segment::Item item;
    Index first;
  };
  std::vector<Place> places;
  Index first = 0;
  for (const auto* items : {&others.items, &of_state.items}) {
    for (const Segment::Item& item : *items) {
      places.push_back({item, first});
      first += item.size;
    }
  }
  std::ranges::sort(places, {}, [](const Place& p) { return p.item.number; });
  Carried result;
  std::vector<Index> order;
  for (const Place& place : places) {
    result.items.push_back(place.item);
    for (int i = 0; i < place.item.size; ++i) order.push_back(place.first + i);
  }
  result.C = C(order, Eigen::all);
  result.P = P(order, order);
  result.correction = correction(order);
  return result;
}

// Their rows are copied to the end of the error vector, or follow from the shared errors.
void Ekf::revive_considered(std::span<const int> numbers) {
  if (numbers.empty()) return;
  ConsideredMap& map = *state_.considered;
  const OfState of_state = considered_of_state(numbers);
  const Index n = covariance_.size(), k = of_state.d.rows();
  const MatrixXd d_transposed = of_state.d.transpose();
  const MatrixXd C = dense::product(of_state.d, covariance_.all());
  const int row = covariance_.append(static_cast<int>(k));
  auto P = covariance_.all();
  P.block(row, 0, k, n) = C;
  P.block(0, row, n, k) = C.transpose();
  P.bottomRightCorner(k, k) = dense::product(C, d_transposed) + of_state.own;
  const MatrixXd with_latest = dense::product(latest_.Z(), d_transposed);
  latest_.append_rows(static_cast<int>(k));
  latest_.Z().rightCols(k) = with_latest;
  const std::size_t first = state_.landmarks.size();
  std::vector<Vector3d> before;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Landmark landmark = past_.landmark(numbers[i]);
    const auto away = std::ranges::find(map.away, std::optional(numbers[i]), &Landmark::considered);
    if (away != map.away.end()) {
      landmark = *away;
      map.away.erase(away);
    }
    before.push_back(landmark.p_world);
    landmark.considered = numbers[i];
    landmark.row = row + 3 * static_cast<int>(i);
    landmark.p_world = considered_place(state_, numbers[i]);
    state_.landmarks.push_back(landmark);
  }
  keep_rows();
  past_.note_returned({numbers.begin(), numbers.end()});
  const std::optional<VectorXd> scale =
      options_.keep_scale ? scale_error({state_.landmarks.data(), first}) : std::nullopt;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Landmark& landmark = state_.landmarks[first + i];
    move_to_present_mean(before[i], landmark, scale);
    to_world_axes(landmark);
  }
}

// Its rows are given up where it was in the state.
void Ekf::drop_considered(int number) {
  const auto gone = std::erase_if(state_.considered->away,
                                  [&](const Landmark& l) { return l.considered == number; });
  if (gone > 0) keep_rows();
}

// The landmarks of a considered map that are not in the state.
void Ekf::append_considered(Past::Estimates& estimates) const {
  const ConsideredMap& map = *state_.considered;
  const PriorMap& prior = past_.prior(map.frame);
  const MatrixXd P = covariance_.all().block(map.row, map.row, map.mean.size(), map.mean.size());
  for (std::size_t i = 0; i < prior.landmarks.size(); ++i) {
    const int number = map.frame + 1 + static_cast<int>(i);
    if (past_.has_returned(number)) continue;
    const auto away = std::ranges::find(map.away, std::optional(number), &Landmark::considered);
    const auto A = prior.shared.middleRows<3>(6 + 3 * static_cast<Index>(i));
    const Landmark& landmark = away == map.away.end() ? prior.landmarks[i] : *away;
    const Matrix3d covariance =
        away == map.away.end()
            ? Matrix3d(A * P * A.transpose() + prior.own[i])
            : Matrix3d(covariance_.all().block<3, 3>(landmark.row, landmark.row));
    estimates.landmarks.push_back({.id = landmark.id,
                                   .p_world = considered_place(state_, number),
                                   .covariance = covariance,
                                   .observations = landmark.observations});
  }
}

}  // namespace chasles
