#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/multi_view_start.hpp>

namespace chasles {

/// A track whose point is not in the state: its views wait until they determine the depth.
struct WaitingTrack {
  LandmarkId id = 0;
  std::vector<ClonedView> views;
  int seen = 0;           ///< number of the latest frame
  CameraSet cameras = 0;  ///< that follow it
  bool ended = false;     ///< it is now a landmark, or no longer in view
};

}  // namespace chasles
