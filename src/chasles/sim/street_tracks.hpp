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

/// A point that the cameras follow from frame to frame, and what they see of it without noise.
struct Track {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< at its birth [m]
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();  ///< not zero on a moving thing [m/s]
  double birth = 0;                                   ///< [s]
  double end = 0;                                     ///< its life is over then, at the latest [s]
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();   ///< (uL, vL, uR, vR) in the latest frame
};

/// What does not change from frame to frame.
struct StreetView {
  const StreetSettings& settings;
  const StreetDrive& drive;
  const StreetWorld& world;
  const StereoRig& rig;
};

/// The tracks that are alive, in the order of their ids, and all that ever were born.
struct Tracks {
  std::vector<Track> alive;
  std::vector<Track> born;
};

/// Follows the tracks to the frame of a number and a time [s]. A track ends, for ever, when its
/// landmark leaves one of the images or the range of depths, when a block hides it, or when its
/// life is over; as many new ones are born as are missing. A new one is a ray through a random
/// pixel of the left image, followed to the façade or the road that it meets: spread evenly over
/// the image, as a detector's corners. Those that will soon be out of view are not taken, as
/// trackers drop their short tracks. The random numbers depend on the seed and the frame's number
/// only.
void follow(Tracks& tracks, const StreetView& view, std::uint64_t frame, double time);

}  // namespace chasles
