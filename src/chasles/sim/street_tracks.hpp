#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/sim/street_drive.hpp>
#include <chasles/sim/street_settings.hpp>
#include <chasles/sim/street_world.hpp>

namespace chasles {

/// A point that the cameras track from frame to frame, and its pixels without noise.
struct StreetTrack {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< at its first frame [m]
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();  ///< not zero on a moving object [m/s]
  double birth = 0;                                   ///< [s]
  double end = 0;                                     ///< latest time of the track [s]
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();   ///< (uL, vL, uR, vR) in the latest frame
};

/// The inputs that do not change from frame to frame.
struct StreetView {
  const StreetSettings& settings;
  const StreetDrive& drive;
  const StreetWorld& world;
  const StereoRig& rig;
};

/// The current tracks in order of their ids, and all tracks so far.
struct Tracks {
  std::vector<StreetTrack> alive;
  std::vector<StreetTrack> born;
};

/// Advances the tracks to the frame with this number and time [s]. A track ends for good when its
/// landmark leaves one of the images or the range of depths, when a block occludes it, or at its
/// latest time. As many new tracks start as are missing. A new track starts at a random pixel of
/// the left image; its ray is followed to the façade or the road. The tracks are therefore spread
/// evenly over the image, like a detector's corners. Points that will soon be out of view are not
/// taken, as trackers drop their short tracks. The random numbers depend on the seed and the
/// frame's number only.
void follow(Tracks& tracks, const StreetView& view, std::uint64_t frame, double time);

}  // namespace chasles
