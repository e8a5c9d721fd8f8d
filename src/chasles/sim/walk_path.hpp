#pragma once

#include <chasles/lie/trajectory.hpp>
#include <chasles/recording/plan.hpp>
#include <chasles/sim/floor_plan.hpp>
#include <chasles/sim/inertial_path.hpp>

namespace chasles {

/// The building of the scene `walk`: two rectangular loops of corridors (`hall_length` by
/// `hall_width` along their centre lines) on both sides of a passage that widens to a hall. Along
/// the walls are alcoves, and offices behind doorways. The walk starts above the origin, along the
/// passage. Throws UsageError if the building is too small for its rooms or for the walker's turns.
FloorPlan walk_plan(const InertialSettings& settings);

/// The furniture [m]: lintels, cupboards, benches, desks, pillars.
std::vector<Box> walk_furniture(const InertialSettings& settings);

/// Both for drawing: walls, and the outlines of the furniture on the floor.
Plan drawn_walk_plan(const InertialSettings& settings);

/// The poses world_T_imu of a pedestrian, as `hallway_path`: through the passage, around the left
/// loop, through the passage again, around the right loop, and so on for all `sections`, or until
/// `walk_duration`. Throws UsageError if the path would touch a wall or a piece of furniture.
Trajectory walk_path(const InertialSettings& settings);

}  // namespace chasles
