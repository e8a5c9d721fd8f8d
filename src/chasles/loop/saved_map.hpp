#pragma once

#include <map>
#include <optional>
#include <span>

#include <chasles/loop/landmark_map.hpp>
#include <chasles/loop/loop_matching.hpp>
#include <chasles/loop/placed_map.hpp>

namespace chasles {

/// What a run knows of its landmarks.
struct MappedLandmarks {
  const Ekf& filter;
  const PastLandmarks& past;
  const std::map<LandmarkId, Appearance>& appearances;  ///< of landmarks in the state
  const std::optional<PlacedMap>& placed;               ///< the map that the run continues, if any
};

/// A landmark of the state that was observed so often is a point, and remains one.
inline constexpr int kLeastObservations = 10;

/// What another run can recognise of them: `most` landmarks that cover the space. The frame is that
/// of the placed map, else nav. With `until`, of own landmarks only those that have left before, on
/// the cameras' clock. `end`: the time of the filter, on the IMU's.
LandmarkMap saved_map(const MappedLandmarks& landmarks, std::span<const Camera> cameras, int most,
                      Time end, std::optional<Time> until);

}  // namespace chasles
