#include <algorithm>
#include <numeric>
#include <vector>

#include <chasles/filter/ekf.hpp>

// Landmarks and poses that leave the state (docs/map.md).

namespace chasles {
namespace {

void remove_landmarks(std::span<const int> indices, std::vector<Landmark>& landmarks) {
  for (auto index = indices.rbegin(); index != indices.rend(); ++index) {
    landmarks.erase(landmarks.begin() + *index);
  }
}

}  // namespace

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
  past_.keep_rows(rows);
}

void Ekf::retire(std::span<const int> indices) {
  if (indices.empty()) return;
  for (const int index : indices) {
    Landmark& landmark = state_.landmarks[static_cast<std::size_t>(index)];
    if (past_.is_in_map_axes() && landmark.has_place()) {
      make_cartesian(index);
      to_map_axes(landmark);
    }
    if (landmark.considered) {
      past_.note_left(*landmark.considered);
      state_.considered->away.push_back(landmark);
    } else {
      past_.leave(landmark, state_, covariance_);
    }
  }
  past_.end_leaving(indices, state_);
  remove_landmarks(indices, state_.landmarks);
  keep_rows();
}

void Ekf::remove(std::span<const int> indices) {
  past_.reject_with_history("the removal of landmarks needs");
  remove_landmarks(indices, state_.landmarks);
  keep_rows();
}

void Ekf::remember_pose(Time time) { past_.remember_pose(time, state_, covariance_); }

void Ekf::remember_pose(Time time, const SE3& map_T_imu, const Eigen::MatrixXd& d_core) {
  past_.remember_pose(time, map_T_imu, d_core, covariance_);
}

}  // namespace chasles
