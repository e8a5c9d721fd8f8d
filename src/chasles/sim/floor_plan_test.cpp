#include <gtest/gtest.h>

#include <chasles/sim/floor_plan.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

double area(const std::vector<PlanRectangle>& rectangles) {
  double sum = 0;
  for (const PlanRectangle& r : rectangles) sum += (r.high - r.low).prod();
  return sum;
}

// By Green's theorem: free space lies to the left of every wall.
double enclosed(const std::vector<WallSegment>& walls) {
  double sum = 0;
  for (const WallSegment& w : walls) sum += (w.a.x() * w.b.y() - w.a.y() * w.b.x()) / 2;
  return sum;
}

double length(const std::vector<WallSegment>& walls) {
  double sum = 0;
  for (const WallSegment& w : walls) sum += (w.b - w.a).norm();
  return sum;
}

// A ring of corridors two metres wide round a block of 6 x 2, with a niche outside.
FloorPlan ring() {
  return {.rooms = {{{0, 0}, {10, 2}},
                    {{0, 4}, {10, 6}},
                    {{0, 0}, {2, 6}},
                    {{8, 0}, {10, 6}},
                    {{4, -1}, {5, 0}}}};
}

TEST(FloorPlan, ARoomHasFourWallsThatEncloseIt) {
  const FloorPlan plan{.rooms = {{{-1, 2}, {3, 5}}}};
  EXPECT_EQ(plan_walls(plan).size(), 4U);
  EXPECT_DOUBLE_EQ(length(plan_walls(plan)), 14);
  EXPECT_DOUBLE_EQ(enclosed(plan_walls(plan)), 12);
  EXPECT_TRUE(plan_solids(plan).empty());
}

TEST(FloorPlan, WallsEncloseTheUnionOfOverlappingRooms) {
  const auto walls = plan_walls(ring());
  EXPECT_DOUBLE_EQ(enclosed(walls), 60 - 12 + 1);
  EXPECT_DOUBLE_EQ(length(walls), 32 + 2 + 16);
  // Four inner ones; outside three whole ones, two halves of the wall with the niche, three of it.
  EXPECT_EQ(walls.size(), 4U + 3U + 2U + 3U);
  Vector2d sum = Vector2d::Zero();
  for (const WallSegment& wall : walls) sum += wall.b - wall.a;
  EXPECT_LT(sum.norm(), 1e-12) << "the loops are not closed";
}

TEST(FloorPlan, FloorsAndSolidsTileTheBoundingBox) {
  EXPECT_DOUBLE_EQ(area(plan_floors(ring())), 49);
  EXPECT_DOUBLE_EQ(area(plan_solids(ring())), 70 - 49);
}

TEST(FloorPlan, WallsAreJoinedToClosedLoopsThatEncloseTheSame) {
  // Two rooms that touch at a corner, besides: four walls meet there.
  FloorPlan plan = ring();
  plan.rooms.push_back({{10, 6}, {12, 9}});
  const auto walls = plan_walls(plan);
  const auto loops = wall_loops(walls);
  EXPECT_LE(loops.size(), 3U);
  double area = 0, length = 0;
  std::size_t pieces = 0;
  for (const auto& loop : loops) {
    EXPECT_EQ(loop.front(), loop.back());
    pieces += loop.size() - 1;
    for (std::size_t i = 1; i < loop.size(); ++i) {
      const Vector2d &a = loop[i - 1], &b = loop[i];
      EXPECT_EQ((b - a).cwiseAbs().minCoeff(), 0) << "a wall that is not in the plan";
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
      length += (b - a).norm();
    }
  }
  EXPECT_EQ(pieces, walls.size());
  EXPECT_DOUBLE_EQ(area, 49 + 6);
  EXPECT_DOUBLE_EQ(length, 50 + 10);
  EXPECT_TRUE(wall_loops({}).empty());
}

TEST(FloorPlan, EdgesThatDifferByRoundOffAreOne) {
  const FloorPlan plan{.rooms = {{{0, 0}, {0.1 + 0.2, 1}}, {{0.3, 0}, {1, 1}}}};
  EXPECT_EQ(plan_walls(plan).size(), 4U);
}

TEST(FloorPlan, KnowsTheNearestWall) {
  const auto walls = plan_walls(ring());
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {1, 1.2}), 1);
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {5, 1.7}), 0.3);
  // Over the opening of the niche: from its corners.
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {4.5, 0}), 0.5);
  EXPECT_DOUBLE_EQ(distance_to_walls(walls, {13, 10}), 5);
}

}  // namespace
}  // namespace chasles
