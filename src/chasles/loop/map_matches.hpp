#pragma once

#include <vector>

#include <chasles/loop/map_fusion.hpp>

// Which landmarks of two maps are the same.
namespace chasles {

/// The largest NIS of so many matches together, with a probability of 99.9 %.
double most_nis(int matches);

/// Removes matches that contradict the others (99 %), worst first, until all agree.
void drop_contradictions(const MapFusion& both, std::vector<MapFusion::Match>& matches);

/// Adds further landmarks that look the same where they should be (99 %).
void add_matches(const MapFusion& both, std::vector<MapFusion::Match>& matches);

}  // namespace chasles
