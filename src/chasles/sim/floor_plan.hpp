#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// An axis-parallel rectangle in the world's x-y plane [m].
struct PlanRectangle {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

/// The free space: the union of rectangles, which may overlap. Edges closer than a micrometre to
/// each other count as one.
struct FloorPlan {
  std::vector<PlanRectangle> rooms;
};

/// A straight wall. The free space is to the left of the direction from a to b.
struct WallSegment {
  Eigen::Vector2d a, b;
};

/// The boundary of the plan: each straight piece once, without overlaps. Together the pieces form
/// closed loops.
std::vector<WallSegment> plan_walls(const FloorPlan& plan);

/// The walls joined to closed loops. Each loop starts and ends at the same corner, with the free
/// space to the left.
std::vector<std::vector<Eigen::Vector2d>> wall_loops(const std::vector<WallSegment>& walls);

/// The plan as rectangles without overlaps.
std::vector<PlanRectangle> plan_floors(const FloorPlan& plan);

/// The solid remainder of the plan's bounding box as rectangles without overlaps.
std::vector<PlanRectangle> plan_solids(const FloorPlan& plan);

/// The distance from a point to the nearest wall [m]; infinity without walls.
double distance_to_walls(const std::vector<WallSegment>& walls, const Eigen::Vector2d& p);

}  // namespace chasles
