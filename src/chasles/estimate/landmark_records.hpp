#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// How a landmark of the state has been observed.
struct LandmarkRecord {
  int seen = 0;           ///< number of the latest frame
  CameraSet cameras = 0;  ///< that follow its track
  int missed = 0;         ///< later frames in which one of them observes anything
  int rejected = 0;       ///< consecutive frames in which the gate rejected it
  int matches = 0;        ///< used (PixelObservation::is_match())
};

/// Of all landmarks of a state, in the order of State::landmarks.
using LandmarkRecords = std::vector<LandmarkRecord>;

/// Removes the records of landmarks that leave the state (indices, rising).
inline void remove(LandmarkRecords& records, std::span<const int> indices) {
  for (auto i = indices.rbegin(); i != indices.rend(); ++i) records.erase(records.begin() + *i);
}

/// Finds the landmarks of a state by their ids. It keeps its memory.
class LandmarkIndex {
 public:
  void set(const State& x) {
    indices_.clear();
    for (const Landmark& landmark : x.landmarks) {
      indices_.emplace_back(landmark.id, static_cast<int>(indices_.size()));
    }
    std::sort(indices_.begin(), indices_.end());
  }

  /// The index into State::landmarks.
  std::optional<int> find(LandmarkId id) const {
    const auto found = std::lower_bound(indices_.begin(), indices_.end(), std::pair(id, 0));
    if (found == indices_.end() || found->first != id) return std::nullopt;
    return found->second;
  }

 private:
  std::vector<std::pair<LandmarkId, int>> indices_;  ///< sorted by id
};

}  // namespace chasles
