#pragma once

#include <vector>

#include <chasles/data/run.hpp>

namespace chasles {
struct MapLandmark;
}

namespace chasles::app {

/// Converts the map to the landmarks of a run. ObservationSpans adds the times of observation.
std::vector<RunLandmark> run_landmarks(const std::vector<MapLandmark>& map);

}  // namespace chasles::app
