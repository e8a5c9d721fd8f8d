#include <algorithm>
#include <numeric>
#include <utility>

#include <chasles/filter/ekf.hpp>

// How the filter lets go of landmarks and gives account of the whole map (docs/map.md).

namespace chasles {
namespace {

std::vector<int> rows_of(int core, const std::vector<Landmark>& landmarks) {
  std::vector<int> rows(static_cast<std::size_t>(core));
  std::iota(rows.begin(), rows.end(), 0);
  for (const Landmark& landmark : landmarks) {
    for (int i = 0; i < 3; ++i) rows.push_back(landmark.row + i);
  }
  return rows;
}

}  // namespace

void Ekf::retire(std::span<const int> indices) {
  if (indices.empty()) return;
  History::Removal step{.indices = {indices.begin(), indices.end()}, .landmarks = {}};
  for (const int index : indices) {
    step.landmarks.push_back(state_.landmarks[static_cast<std::size_t>(index)]);
  }
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    state_.landmarks.erase(state_.landmarks.begin() + *index);
  }
  if (!options_.compress_map) {
    retired_.insert(retired_.end(), step.landmarks.begin(), step.landmarks.end());
    return;
  }
  history_.append(std::move(step));
  covariance_.keep(rows_of(state_.core_size(), state_.landmarks));
  for (std::size_t i = 0; i < state_.landmarks.size(); ++i) {
    state_.landmarks[i].row = state_.core_size() + 3 * static_cast<int>(i);
  }
}

int Ekf::map_size() const {
  return history_.removed() + static_cast<int>(retired_.size() + state_.landmarks.size());
}

std::vector<MapLandmark> Ekf::map() const {
  std::vector<MapLandmark> result = history_.landmarks();
  const auto P = covariance_.all();
  for (const std::vector<Landmark>* landmarks : {&retired_, &state_.landmarks}) {
    for (const Landmark& landmark : *landmarks) {
      result.push_back({.id = landmark.id,
                        .p_world = landmark.p_world,
                        .covariance = P.block<3, 3>(landmark.row, landmark.row),
                        .observations = landmark.observations});
    }
  }
  return result;
}

void Ekf::visit_map_covariance(const History::RowVisitor& visit) const {
  if (options_.compress_map) {
    history_.visit_covariance(visit);
    return;
  }
  std::vector<Landmark> landmarks = retired_;
  landmarks.insert(landmarks.end(), state_.landmarks.begin(), state_.landmarks.end());
  std::vector<int> rows = rows_of(state_.core_size(), landmarks);
  std::rotate(rows.begin(), rows.begin() + state_.core_size(), rows.end());
  visit(0, covariance_.all()(rows, rows));
}

}  // namespace chasles
