#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// An axis-parallel rectangle in the world's x-y plane [m].
struct PlanRectangle {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

/// Where one can walk: the union of rectangles, which may overlap. Edges nearer to each other than
/// a micrometre count as one.
struct FloorPlan {
  std::vector<PlanRectangle> rooms;
};

/// A straight wall; who walks from a to b has the free space on the left hand.
struct WallSegment {
  Eigen::Vector2d a, b;
};

/// The boundary of the plan: each straight piece once, without overlaps. Together they are closed
/// loops.
std::vector<WallSegment> plan_walls(const FloorPlan& plan);

/// Those walls joined to closed loops, each beginning and ending at the same corner, with the free
/// space on the left hand.
std::vector<std::vector<Eigen::Vector2d>> wall_loops(const std::vector<WallSegment>& walls);

/// Rectangles without overlaps that together are the plan.
std::vector<PlanRectangle> plan_floors(const FloorPlan& plan);

/// Rectangles without overlaps that are the rest of the plan's bounding box: what is solid.
std::vector<PlanRectangle> plan_solids(const FloorPlan& plan);

/// From a point to the nearest of the walls [m]; infinity where there is none.
double distance_to_walls(const std::vector<WallSegment>& walls, const Eigen::Vector2d& p);

}  // namespace chasles
