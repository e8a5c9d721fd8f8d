#pragma once

#include <array>
#include <cstdint>

#include <chasles/viewers/colmap.hpp>

// What the files of COLMAP's model and its database have in common.
namespace chasles {

/// COLMAP counts from 1.
inline std::uint32_t colmap_id(std::size_t index) { return static_cast<std::uint32_t>(index + 1); }

inline constexpr std::uint32_t kColmapRig = 1;  ///< the id of the only one
inline constexpr int kColmapCamera = 0;         ///< a sensor of this type

/// A pose of COLMAP: qw qx qy qz tx ty tz.
std::array<double, 7> colmap_pose(const SE3& pose);

/// world_T_cam of a camera of the model at a frame.
SE3 world_T_camera(const ColmapModel& model, const ColmapFrame& frame, std::size_t camera);
/// What maps the coordinates of the first camera to those of another one.
SE3 camera_T_first(const ColmapModel& model, std::size_t camera);

}  // namespace chasles
