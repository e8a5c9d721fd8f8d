#include <algorithm>
#include <numeric>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/small_matrices.hpp>

// Retirement of landmarks and access to the whole map (docs/map.md).

namespace chasles {

// Removes the rows that no state has any longer, and renumbers the others without gaps.
void Ekf::keep_rows() {
  std::vector<int>& rows = work_.rows;
  rows.resize(static_cast<std::size_t>(state_.core_size()));
  std::iota(rows.begin(), rows.end(), 0);
  const auto take = [&](int& row, int width) {
    const int first = row;
    row = static_cast<int>(rows.size());
    for (int i = 0; i < width; ++i) rows.push_back(first + i);
  };
  auto& kept = work_.kept;
  kept.clear();
  for (Landmark& landmark : state_.landmarks) kept.push_back({&landmark.row, 3});
  for (Clone& clone : state_.clones) kept.push_back({&clone.row, 6});
  if (state_.considered) {
    kept.push_back({&state_.considered->row, static_cast<int>(state_.considered->mean.size())});
    for (Landmark& landmark : state_.considered->away) kept.push_back({&landmark.row, 3});
  }
  std::ranges::sort(kept, {}, [](const auto& one) { return *one.first; });
  for (const auto& one : kept) take(*one.first, one.width);
  covariance_.keep(rows);
  latest_.keep_rows(rows);
}

// The position of an anchored landmark also depends on its anchor.
MapLandmark Ekf::as_of_now(const Landmark& landmark) const {
  const auto P = covariance_.all();
  MapLandmark result{.id = landmark.id,
                     .p_world = state_.p_world(landmark),
                     .covariance = P.block<3, 3>(landmark.row, landmark.row),
                     .observations = landmark.observations};
  if (!landmark.anchor) return result;
  const Clone& clone = state_.clone(*landmark.anchor);
  Eigen::Matrix<double, 3, 9> J;
  J << anchored_derivative(clone, landmark);
  Eigen::Matrix<double, 9, 9> block;
  block.topLeftCorner<6, 6>() = P.block<6, 6>(clone.row, clone.row);
  block.bottomRightCorner<3, 3>() = P.block<3, 3>(landmark.row, landmark.row);
  block.bottomLeftCorner<3, 6>() = P.block<3, 6>(landmark.row, clone.row);
  block.topRightCorner<6, 3>() = block.bottomLeftCorner<3, 6>().transpose();
  result.covariance = congruence(J, block);
  if (const auto camera = state_.camera_row(landmark.camera)) {
    const auto J_camera = anchored_derivative_by_camera(clone, landmark);
    const Eigen::Matrix3d cross = (J.leftCols<6>() * P.block<6, 6>(clone.row, *camera) +
                                   J.rightCols<3>() * P.block<3, 6>(landmark.row, *camera)) *
                                  J_camera.transpose();
    result.covariance += cross + cross.transpose() +
                         J_camera * P.block<6, 6>(*camera, *camera) * J_camera.transpose();
  }
  return result;
}

void Ekf::retire(std::span<const int> indices) {
  if (indices.empty()) return;
  if (has_past()) {
    leave(indices);
    return;
  }
  std::vector<Landmark>& gone = work_.gone;
  gone.clear();
  for (const int index : indices) {
    gone.push_back(state_.landmarks[static_cast<std::size_t>(index)]);
  }
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    state_.landmarks.erase(state_.landmarks.begin() + *index);
  }
  if (remembers()) {
    history_.append(
        History::Removal{.indices = {indices.begin(), indices.end()}, .landmarks = gone});
  } else {
    for (const Landmark& landmark : gone) {
      if (landmark.has_place()) frozen_.push_back(as_of_now(landmark));
    }
  }
  keep_rows();
}

int Ekf::map_size() const {
  return history_.removed() + past_.landmarks() + static_cast<int>(frozen_.size()) +
         static_cast<int>(std::ranges::count_if(state_.landmarks, &Landmark::has_place));
}

std::vector<MapLandmark> Ekf::map() const { return past_estimates().landmarks; }

void Ekf::visit_map_covariance(const History::RowVisitor& visit) const {
  if (options_.map == Map::kDense) {
    visit_dense_covariance(visit);
    return;
  }
  if (!history_.is_complete()) {
    throw UsageError(
        "the covariance of the whole map needs all steps of the filter: expected map_memory 0");
  }
  history_.visit_covariance(visit);
}

}  // namespace chasles
