#pragma once

#include <span>
#include <vector>

#include <chasles/loop/merge_maps.hpp>

// Several runs may begin in one map at the same time. Each leaves an extension of it: the map,
// corrected by what the run measured, and the run's own landmarks.
namespace chasles {

/// Whether `map` has the sessions of `base` first, and more.
bool extends(const LandmarkMap& map, const LandmarkMap& base);

/// Of each landmark of `map` the index of the same one of `base`, by its descriptors; -1: none.
std::vector<int> points_of(const LandmarkMap& base, const LandmarkMap& map);

/// One map of several extensions, in the frame of `base`. What they have from `base` counts once:
/// given its landmarks, what the runs measured is independent, and counts fully. For these
/// landmarks themselves every extension counts by one n-th (covariance intersection, Julier &
/// Uhlmann, ACC 1997), which is consistent for errors that are correlated in any way. The order of
/// the extensions decides the bytes. Throws InputError where one lacks most landmarks of `base`, or
/// contradicts the others.
LandmarkMap joined_extensions(const LandmarkMap& base, std::span<const MapPart> extensions);

}  // namespace chasles
