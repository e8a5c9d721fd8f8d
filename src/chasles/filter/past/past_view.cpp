#include <algorithm>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/considered_map.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/past_view.hpp>
#include <chasles/filter/present_landmark.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Carried PastView::recall(std::span<const int> numbers) const {
  const Past& left = kept_.left();
  const auto [others, considered] = apart_from_considered(state_, left, numbers);
  const std::vector<int> sources = left.sources(others);
  Carried past = left.recall(sources);
  carry(past, kept_.latest().segment(), sources);
  past = left.derived(past, others);
  if (considered.empty()) return past;
  return with_considered(past, considered_of_state(state_, left, considered, covariance_.size()),
                         covariance_);
}

Carried PastView::recall(std::span<const int> numbers, std::span<const int> landmarks) const {
  Carried result = recall(numbers);
  const Index n = covariance_.size(), k = result.rows(),
              m = 3 * static_cast<Index>(landmarks.size());
  if (k == 0) result.C.resize(0, n);
  MatrixXd d(m, n);
  VectorXd correction(k + m);
  correction.head(k) = result.correction;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const Landmark& landmark = state_.landmarks[static_cast<std::size_t>(landmarks[i])];
    const Index at = 3 * static_cast<Index>(i);
    d.middleRows<3>(at) = derivative_in_map_axes(state_, landmark, n);
    const Vector3d p_world = state_.p_world(landmark);
    correction.segment<3>(k + at) = state_.nav_T_world ? *state_.nav_T_world * p_world : p_world;
    result.items.push_back({.number = -1, .size = 3});
  }
  const MatrixXd P_all = covariance_.all(), d_transposed = d.transpose();
  MatrixXd C(k + m, n), P(k + m, k + m);
  C << result.C, dense::product(d, P_all);
  P.topLeftCorner(k, k) = result.P;
  P.rightCols(m) = dense::product(C, d_transposed);
  P.bottomLeftCorner(m, k) = P.topRightCorner(k, m).transpose();
  result.C = std::move(C);
  result.P = std::move(P);
  result.correction = std::move(correction);
  return result;
}

Past::Estimates PastView::estimates() const {
  const bool has_axes = kept_.is_in_map_axes();
  Past::Estimates result =
      has_axes ? kept_.left().estimates(kept_.latest().segment()) : kept_.history().estimates();
  if (state_.considered) {
    const auto considered = considered_landmarks(state_, kept_.left(), covariance_);
    result.landmarks.insert(result.landmarks.end(), considered.begin(), considered.end());
  }
  result.landmarks.insert(result.landmarks.end(), kept_.frozen().begin(), kept_.frozen().end());
  for (const Landmark& landmark : state_.landmarks) {
    if (!landmark.has_place()) continue;
    result.landmarks.push_back(has_axes ? in_map_axes(state_, covariance_, landmark)
                                        : as_of_now(state_, covariance_, landmark));
  }
  return result;
}

int PastView::map_size() const {
  return kept_.history().removed() + kept_.left().landmarks() +
         static_cast<int>(kept_.frozen().size()) +
         static_cast<int>(std::ranges::count_if(state_.landmarks, &Landmark::has_place));
}

void PastView::visit_map_covariance(const History::RowVisitor& visit) const {
  if (kept_.map() == KeptPast::Map::kDense) {
    visit_dense_covariance(visit);
    return;
  }
  if (!kept_.history().is_complete()) {
    throw UsageError(
        "the covariance of the whole map needs all steps of the filter: expected map_memory 0");
  }
  kept_.history().visit_covariance(visit);
}

void PastView::visit_dense_covariance(const History::RowVisitor& visit) const {
  std::vector<int> landmarks;
  for (const Segment::Item& item : kept_.latest().items()) {
    if (item.size == 3) landmarks.push_back(item.number);
  }
  const Segment past = with_items(kept_.latest().segment(), landmarks);
  const Index q = past.g.size(), n = covariance_.size();
  std::vector<int> rows;
  const auto take = [&](int first, int size) {
    for (int i = 0; i < size; ++i) rows.push_back(first + i);
  };
  for (const Landmark& landmark : state_.landmarks) take(landmark.row, 3);
  take(0, state_.core_size());
  MatrixXd whole(q + n, q + n);
  whole << past.G, past.X(rows, Eigen::all).transpose(), past.X(rows, Eigen::all),
      covariance_.all()(rows, rows);
  visit(0, whole);
}

}  // namespace chasles
