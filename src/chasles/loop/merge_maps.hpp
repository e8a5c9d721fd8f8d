#pragma once

#include <span>
#include <string>
#include <vector>

#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/place.hpp>

namespace chasles {

/// A map that was not merged: of one run, or of runs that each began in the map of those before.
struct MapPart {
  std::string name;  ///< for messages
  LandmarkMap map;
  /// The file that it comes from. A map, and what runs that began in it at the same time left of
  /// it, may be together in one file; in different ones they are different maps of one recording.
  int file = -1;
};

struct MergedMaps {
  LandmarkMap map;
  /// In their order: by the begin and the name of their first sessions. The frame is that of the
  /// first part. Empty where all were the same part, which is then the map. A part that another one
  /// extends is among them only where several do (map_family.hpp).
  std::vector<LandmarkMap> parts;
  /// The other parts, in the order in which their places were found.
  struct Joined {
    std::vector<MapSession> sessions;
    int matches = 0;  ///< landmarks that both have
    double nis = 0;   ///< of their differences together; three degrees of freedom each
  };
  std::vector<Joined> joined;
};

/// Merges maps at the places that they saw. The information of each counts once: what a landmark of
/// one map adds to the same landmark of another corrects both maps as wholes. A part that is
/// given twice counts once. The result depends on the parts only, not on the order in which they
/// are given. Throws InputError where maps have no place in common with the others, contradict them
/// there, or where two have sessions of one recording.
MergedMaps merge_maps(std::vector<MapPart> parts);

/// Two maps in the frame of the first one.
struct JoinedMaps {
  LandmarkMap map;
  SE3 a_T_b;
  int matches = 0;
  double nis = 0;
};

/// The step of merge_maps(), with given matches (a landmark of b is `seen`, one of a is `point`)
/// and place, and without a check of them. The place is where it is linearised.
JoinedMaps join_maps(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
                     std::span<const PlaceInMap::Match> matches);

}  // namespace chasles
