#include "run_landmarks.hpp"

#include <chasles/filter/history.hpp>

namespace chasles::app {

std::vector<RunLandmark> run_landmarks(const std::vector<MapLandmark>& map) {
  std::vector<RunLandmark> result;
  for (const MapLandmark& l : map) {
    result.push_back({.id = l.id,
                      .p_world = l.p_world,
                      .covariance = l.covariance,
                      .observations = l.observations});
  }
  return result;
}

}  // namespace chasles::app
