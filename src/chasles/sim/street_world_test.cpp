#include <gtest/gtest.h>

#include <chasles/sim/street_world.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

// One house, 10 m ahead and 20 m long and wide, on a flat road 1 m below the origin.
StreetWorld one_house() {
  return {.blocks = {{{10, -10}, {30, 10}}}, .road = {0, 60}, .ground = -1, .roof = 8};
}

TEST(StreetWorld, ARayMeetsTheNearestSurface) {
  const StreetWorld world = one_house();
  EXPECT_NEAR(cast(world, Vector3d::Zero(), {1, 0, 0}).value(), 10, 1e-12);     // the façade
  EXPECT_NEAR(cast(world, Vector3d::Zero(), {2, 0.5, -0.5}).value(), 2, 1e-9);  // the road
  EXPECT_NEAR(cast(world, {40, 0, 0}, {-1, 0, 0}).value(), 10, 1e-12);          // from behind
  EXPECT_NEAR(cast(world, {20, 15, 0}, {0, -1, 0.1}).value(), 5, 1e-12);        // from the side
  EXPECT_FALSE(cast(world, Vector3d::Zero(), {1, 0, 0.9}));                     // over the roof
  EXPECT_FALSE(cast(world, Vector3d::Zero(), {-1, 0, 0}));                      // away from it
  EXPECT_FALSE(cast(world, {0, 11, 0}, {1, 0, 0}));                             // past it
}

TEST(StreetWorld, TheRoadsWavesAreMetWhereTheyAre) {
  StreetWorld world = one_house();
  world.road = {0.2, 30};
  const Vector3d from(-30, 3, 1), ray(1, 0.05, -0.2);
  const Vector3d p = from + cast(world, from, ray).value() * ray;
  EXPECT_NEAR(p.z(), world.ground + world.road.height(p.head<2>()), 1e-8);
}

TEST(StreetWorld, AHouseHidesWhatIsBehindItButNotItsOwnFace) {
  const StreetWorld world = one_house();
  EXPECT_FALSE(blocked(world, Vector3d::Zero(), {10, 3, 2}));
  EXPECT_FALSE(blocked(world, Vector3d::Zero(), {9, 0, -1}));
  EXPECT_TRUE(blocked(world, Vector3d::Zero(), {30, 3, 2}));
  EXPECT_TRUE(blocked(world, Vector3d::Zero(), {40, 0, 0}));
  EXPECT_FALSE(blocked(world, {0, 12, 0}, {40, 12, 0}));
  EXPECT_FALSE(blocked(world, Vector3d::Zero(), {-40, 0, 0}));
}

TEST(StreetWorld, NoHouseStandsInTheWay) {
  const StreetSettings settings;
  const StreetDrive drive = make_street_drive(settings);
  const StreetWorld world = make_street_world(settings, drive);
  EXPECT_GE(world.blocks.size(), 10U);
  for (double way = 0; way <= drive.path.length; way += 0.5) {
    const Eigen::Array2d p = point_at(drive.path, way).p;
    for (const Block& block : world.blocks) {
      EXPECT_FALSE((p > block.low.array() - 1.5).all() && (p < block.high.array() + 1.5).all())
          << way;
    }
  }
}

TEST(StreetWorld, TheRoadsGradientIsTheDerivativeOfItsHeight) {
  const Road road{0.3, 40};
  const double h = 1e-5;
  for (double x = -70; x < 70; x += 7.3) {
    const Eigen::Vector2d p(x, 1.7 * x), dx(h, 0), dy(0, h);
    EXPECT_NEAR(road.gradient(p).x(), (road.height(p + dx) - road.height(p - dx)) / (2 * h), 1e-9);
    EXPECT_NEAR(road.gradient(p).y(), (road.height(p + dy) - road.height(p - dy)) / (2 * h), 1e-9);
  }
}

}  // namespace
}  // namespace chasles
