#include <algorithm>
#include <numeric>
#include <utility>

#include <chasles/error.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/lie/small_matrices.hpp>

// Retirement of landmarks and access to the whole map (docs/map.md).

namespace chasles {
namespace {

}  // namespace

// Returns the rows that are still used, rising, and renumbers them without gaps.
const std::vector<int>& Ekf::renumber_rows() {
  auto& used = work_.used;
  used.clear();
  for (Landmark& landmark : state_.landmarks) used.emplace_back(&landmark.row, 3);
  for (Clone& clone : state_.clones) used.emplace_back(&clone.row, 6);
  if (starts_) used.emplace_back(&starts_->row, starts_->size);
  for (Kept& past : leavers_) used.emplace_back(&past.row, past.size);
  std::ranges::sort(used, {}, [](const auto& part) { return *part.first; });
  std::vector<int>& rows = work_.rows;
  rows.resize(static_cast<std::size_t>(state_.core_size()));
  std::iota(rows.begin(), rows.end(), 0);
  for (const auto& [row, size] : used) {
    const int first = *row;
    *row = static_cast<int>(rows.size());
    for (int i = 0; i < size; ++i) rows.push_back(first + i);
  }
  return rows;
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
  covariance_.keep(renumber_rows());
}

int Ekf::map_size() const {
  return history_.removed() + past_.landmarks() + static_cast<int>(frozen_.size()) +
         static_cast<int>(std::ranges::count_if(state_.landmarks, &Landmark::has_place));
}

std::vector<MapLandmark> Ekf::map() const {
  if (has_past()) return past_estimates().landmarks;
  std::vector<MapLandmark> result = history_.landmarks();
  result.insert(result.end(), frozen_.begin(), frozen_.end());
  for (const Landmark& landmark : state_.landmarks) {
    if (landmark.has_place()) result.push_back(as_of_now(landmark));
  }
  return result;
}

void Ekf::visit_map_covariance(const History::RowVisitor& visit) const {
  if (options_.map == Map::kDense) {
    std::vector<int> rows;
    const auto take = [&](int first, int size) {
      for (int i = 0; i < size; ++i) rows.push_back(first + i);
    };
    for (const Kept& past : leavers_) take(past.row, past.size);
    for (const Landmark& landmark : state_.landmarks) take(landmark.row, 3);
    take(0, state_.core_size());
    visit(0, covariance_.all()(rows, rows));
    return;
  }
  if (!history_.is_complete()) {
    throw UsageError(
        "the covariance of the whole map needs all steps of the filter: expected map_memory 0");
  }
  history_.visit_covariance(visit);
}

}  // namespace chasles
