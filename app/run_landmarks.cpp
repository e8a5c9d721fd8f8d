#include "run_landmarks.hpp"

#include <deque>
#include <unordered_map>

#include <chasles/filter/past/history.hpp>

namespace chasles::app {

std::vector<RunLandmark> run_landmarks(const std::vector<MapLandmark>& map,
                                       std::span<const MapLandmark> initial) {
  // A number may be there several times: both lists have its landmarks in the same order.
  std::unordered_map<LandmarkId, std::deque<const MapLandmark*>> initialised;
  for (const MapLandmark& l : initial) initialised[l.id].push_back(&l);
  std::vector<RunLandmark> result;
  for (const MapLandmark& l : map) {
    result.push_back({.id = l.id,
                      .p_world = l.p_world,
                      .covariance = l.covariance,
                      .observations = l.observations});
    const auto found = initialised.find(l.id);
    if (found == initialised.end() || found->second.empty()) continue;
    const MapLandmark& first = *found->second.front();
    result.back().initial = {.p_world = first.p_world, .covariance = first.covariance};
    found->second.pop_front();
  }
  return result;
}

}  // namespace chasles::app
