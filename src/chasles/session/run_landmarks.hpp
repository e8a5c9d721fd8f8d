#pragma once

#include <span>
#include <vector>

#include <chasles/run_folder/run.hpp>

namespace chasles {
struct MapLandmark;
}

namespace chasles {

/// Converts the map to the landmarks of a run, with `initial` as in EstimatedMap::initial.
/// ObservationSpans adds the times of observation.
std::vector<RunLandmark> run_landmarks(const std::vector<MapLandmark>& map,
                                       std::span<const MapLandmark> initial = {});

}  // namespace chasles
