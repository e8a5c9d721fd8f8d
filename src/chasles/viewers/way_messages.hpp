#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// A foxglove.SceneEntity `id`: a line in the colour 0xRRGGBB along these positions, which
/// `world_T_poses` places.
nlohmann::json way(const std::string& id, const Trajectory& poses, const SE3& world_T_poses,
                   unsigned colour, Time time);

}  // namespace chasles
