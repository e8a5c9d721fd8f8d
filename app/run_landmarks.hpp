#pragma once

#include <vector>

#include <chasles/data/run.hpp>

namespace chasles {
struct MapLandmark;
}

namespace chasles::app {

/// The map as a run has it; when each landmark was seen is told elsewhere (observation_spans.hpp).
std::vector<RunLandmark> run_landmarks(const std::vector<MapLandmark>& map);

}  // namespace chasles::app
