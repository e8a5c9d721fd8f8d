#pragma once

#include <span>

#include <chasles/map/landmark_map.hpp>
#include <chasles/map/place.hpp>

namespace chasles {

/// Two maps in the frame of the first one.
struct MergedMaps {
  LandmarkMap map;
  SE3 a_T_b;
  int matches = 0;  ///< landmarks that both have
  double nis = 0;   ///< of their differences together; three degrees of freedom each
};

/// Merges maps at the places that both saw. The information of each counts once: what a landmark of
/// one map tells about the same landmark of the other corrects both maps as wholes. Throws
/// InputError where the maps have no place in common, contradict each other there, or have sessions
/// of one recording.
MergedMaps merge_maps(const LandmarkMap& a, const LandmarkMap& b);

/// The same with given matches (a landmark of b is `seen`, one of a is `point`) and place, and
/// without a check of them. The place is where it is linearised.
MergedMaps merge_maps(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
                      std::span<const PlaceInMap::Match> matches);

}  // namespace chasles
