#pragma once

#include <chasles/loop/landmark_map.hpp>
#include <chasles/run_folder/map_sketch.hpp>

namespace chasles {

/// What is shown of a map. world_T_map is the identity.
MapSketch map_sketch(const LandmarkMap& map);

}  // namespace chasles
