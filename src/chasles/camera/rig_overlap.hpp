#pragma once

#include <cstddef>
#include <vector>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// The share of a camera's pixels, on a grid, whose points at kNominalDepth are in the image of at
/// least one of `others`. Pixels without a ray do not count; 0 if none has one.
double shared_view(const Camera& camera, const std::vector<Camera>& others);

/// The distance along the ray at which the views of cameras are compared [m].
inline constexpr double kNominalDepth = 5;
/// A camera of which the earlier finders see at least this share only matches their tracks.
inline constexpr double kMostlySeen = 0.5;
/// The tracks of a camera are searched in another one if one of them sees at least this share of
/// the other.
inline constexpr double kBarelySeen = 0.02;

/// A camera that finds tracks, and the cameras in which they are searched.
struct Finder {
  std::size_t camera = 0;
  std::vector<std::size_t> searched = {};  ///< rising
};

/// The roles of the cameras, from their calibration alone: camera 0 finds tracks, and so does every
/// further one of which the finders before it see less than kMostlySeen. In the order of cameras.
std::vector<Finder> finders_of(const std::vector<Camera>& cameras);

/// For each camera, whether it is a finder.
std::vector<bool> are_finders(const std::vector<Camera>& cameras);

/// How many cameras determine depths together: all, if any finder's tracks are searched in another
/// camera; else 1, because the scale is then that of motion alone.
std::size_t cameras_in_stereo(const std::vector<Camera>& cameras);

/// Tracks for each finder: the equal share of `max_tracks`, but at least 40 where max_tracks allows
/// it, for the two-view check needs them. At most max(max_tracks, 40 per finder) in all.
int tracks_per_finder(int max_tracks, std::size_t finders);

}  // namespace chasles
