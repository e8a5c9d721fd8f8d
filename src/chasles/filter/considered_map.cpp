#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

bool is_considered(const State& x, const Past& left, int number) {
  if (!x.considered) return false;
  const int frame = x.considered->frame;
  return number == frame || left.frame_of(number) == frame;
}

}  // namespace

std::pair<std::vector<int>, std::vector<int>> apart_from_considered(const State& x,
                                                                    const Past& left,
                                                                    std::span<const int> numbers) {
  std::pair<std::vector<int>, std::vector<int>> result;
  for (const int number : numbers) {
    (is_considered(x, left, number) ? result.second : result.first).push_back(number);
  }
  return result;
}

Vector3d considered_place(const State& x, const Past& left, int number) {
  const ConsideredMap& map = *x.considered;
  const PriorMap& prior = left.prior(map.frame);
  const Index index = number - map.frame - 1;
  return prior.landmarks[static_cast<std::size_t>(index)].p_world +
         prior.shared.middleRows<3>(6 + 3 * index) * map.mean;
}

void put_considered_in_place(const Past& left, const ErrorRef& delta, State& x) {
  ConsideredMap& map = *x.considered;
  const Index of_frame = left.prior(map.frame).of_frame;
  map.mean.tail(of_frame) += delta.segment(map.row + map.mean.size() - of_frame, of_frame);
  const SE3 world_T_map = x.nav_T_world ? x.nav_T_world->inverse() : SE3{};
  for (Landmark& landmark : x.landmarks) {
    if (!landmark.considered) continue;
    landmark.p_world = world_T_map * considered_place(x, left, *landmark.considered);
  }
}

// With the optimal gain W, P - W W^T. With the gain W - D, where D is W for what is considered and
// 0 for all else, P - W W^T + D D^T. The frame takes W, and the landmarks' rows contain the frame:
// their D is what remains of W without it. The covariances with all that D does not concern, past
// states among them, are those of W.
UnusedGain unused_gain(const State& x, const Past& left, const Whitened& z) {
  const ConsideredMap& map = *x.considered;
  const PriorMap& prior = left.prior(map.frame);
  const Index of_frame = prior.of_frame, fixed = map.mean.size() - of_frame;
  std::vector<const Landmark*> landmarks;
  for (const Landmark& landmark : x.landmarks) {
    if (landmark.considered) landmarks.push_back(&landmark);
  }
  const auto away = static_cast<std::ptrdiff_t>(landmarks.size());
  for (const Landmark& landmark : map.away) landmarks.push_back(&landmark);
  UnusedGain unused;
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
    if (i < away && x.nav_T_world) {
      const SE3& nav_T_world = *x.nav_T_world;
      const int nav = x.nav_row();
      by_frame += hat(nav_T_world.R * landmark.p_world) * z.W.middleRows<3>(nav) -
                  z.W.middleRows<3>(nav + 3);
      by_frame = nav_T_world.R.transpose() * by_frame;
    }
    unused.D.middleRows<3>(fixed + 3 * i) = z.W.middleRows<3>(landmark.row) - by_frame;
    for (int k = 0; k < 3; ++k) unused.rows.push_back(landmark.row + k);
  }
  return unused;
}

OfState considered_of_state(const State& x, const Past& left, std::span<const int> numbers,
                            Index size) {
  const ConsideredMap& map = *x.considered;
  const PriorMap& prior = left.prior(map.frame);
  const Index r = map.mean.size();
  OfState result;
  Index rows = 0;
  for (const int number : numbers) {
    const int rows_of_it = number == map.frame ? static_cast<int>(r) : 3;
    result.items.push_back({.number = number, .size = rows_of_it});
    rows += rows_of_it;
  }
  result.d = MatrixXd::Zero(rows, size);
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
          considered_place(x, left, number) - left.landmark(number).p_world;
    }
    at += item.size;
  }
  return result;
}

Carried with_considered(const Carried& others, const OfState& of_state,
                        const Covariance& covariance) {
  const Index n = covariance.size(), k = others.rows(), m = of_state.d.rows();
  const MatrixXd P_state = covariance.all(), d_transposed = of_state.d.transpose();
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

std::vector<MapLandmark> considered_landmarks(const State& x, const Past& left,
                                              const Covariance& covariance) {
  std::vector<MapLandmark> result;
  const ConsideredMap& map = *x.considered;
  const PriorMap& prior = left.prior(map.frame);
  const MatrixXd P = covariance.all().block(map.row, map.row, map.mean.size(), map.mean.size());
  for (std::size_t i = 0; i < prior.landmarks.size(); ++i) {
    const int number = map.frame + 1 + static_cast<int>(i);
    if (left.has_returned(number)) continue;
    const auto away = std::ranges::find(map.away, std::optional(number), &Landmark::considered);
    const auto A = prior.shared.middleRows<3>(6 + 3 * static_cast<Index>(i));
    const Landmark& landmark = away == map.away.end() ? prior.landmarks[i] : *away;
    const Matrix3d own = away == map.away.end()
                             ? Matrix3d(A * P * A.transpose() + prior.own[i])
                             : Matrix3d(covariance.all().block<3, 3>(landmark.row, landmark.row));
    result.push_back({.id = landmark.id,
                      .p_world = considered_place(x, left, number),
                      .covariance = own,
                      .observations = landmark.observations});
  }
  return result;
}

}  // namespace chasles
