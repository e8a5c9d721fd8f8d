#include <gtest/gtest.h>

#include <chasles/loop/map_testing.hpp>
#include <chasles/loop/place.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

// What a camera at x = 7 m in the corridor sees: the map's points before it, each with some error
// and some bits that differ, and things that are not in the map.
struct Scene {
  std::vector<PlacePoint> seen;
  Vector3d p_camera;
  SE3 world_T_map;
};

Scene scene(const LandmarkMap& map, int known, int others, std::uint64_t seed) {
  test::Random random(seed);
  Scene result{.seen = {}, .p_camera = {}, .world_T_map = test::level_pose(2.2, {30, -11, 4})};
  result.p_camera = result.world_T_map * Vector3d(7, 0.2, 0.1);
  for (std::size_t i = 0; i < map.points.size() && known > 0; ++i) {
    if (map.points[i].p_map.x() < 8.5) continue;
    --known;
    PatchView view = test::seen_again(random, map.points[i].appearance.views().front(), 30);
    view.from = result.world_T_map.R.cast<float>() * view.from;
    // The depth is off by some percent.
    const Vector3d p_world = result.world_T_map * map.points[i].p_map;
    const Vector3d ray = p_world - result.p_camera;
    result.seen.push_back({.p_world = result.p_camera + (1 + 0.05 * random.normal()) * ray +
                                      0.003 * ray.norm() * random.normal_vector(3),
                           .view = view});
  }
  for (int i = 0; i < others; ++i) {
    const Vector3d offset = 4 * random.normal_vector(3);
    result.seen.push_back(
        {.p_world = result.p_camera + offset, .view = test::random_view(random, -offset)});
  }
  return result;
}

TEST(FindPlace, OfACameraThatSeesAFewKnownPoints) {
  const LandmarkMap map = test::corridor_map(3, 200, 40);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene s = scene(map, 10, 30, seed);
    const auto place = find_place(s.seen, s.p_camera, map);
    ASSERT_TRUE(place) << seed;
    EXPECT_GE(place->matches.size(), 8u);
    const SE3 camera_error = s.world_T_map.inverse() * place->world_T_map;
    EXPECT_LT(so3::log(camera_error.R).norm(), 0.05) << seed;
    EXPECT_LT((place->world_T_map * Vector3d(10, 0, 0) - s.world_T_map * Vector3d(10, 0, 0)).norm(),
              0.15);
    for (const PlaceInMap::Match& match : place->matches) {
      EXPECT_LT((s.world_T_map * map.points[static_cast<std::size_t>(match.point)].p_map -
                 s.seen[static_cast<std::size_t>(match.seen)].p_world)
                    .norm(),
                1.5);
    }
  }
}

TEST(FindPlace, NoneWhereTooLittleIsKnown) {
  const LandmarkMap map = test::corridor_map(3, 200, 40);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene s = scene(map, 5, 40, seed);
    EXPECT_FALSE(find_place(s.seen, s.p_camera, map)) << seed;
    const Scene elsewhere = scene(test::corridor_map(4, 200, 40), 40, 0, seed);
    EXPECT_FALSE(find_place(elsewhere.seen, elsewhere.p_camera, map)) << seed;
  }
  EXPECT_FALSE(find_place({}, Vector3d::Zero(), map));
  EXPECT_FALSE(find_place(scene(map, 10, 0, 1).seen, Vector3d::Zero(), {}));
}

// Two corridors that look the same.
TEST(FindPlace, NoneWhereTwoPlacesAreAlike) {
  LandmarkMap map = test::corridor_map(3, 200, 40);
  const Scene s = scene(map, 12, 0, 1);
  ASSERT_TRUE(find_place(s.seen, s.p_camera, map));
  std::vector<MapPoint> points = map.points;
  for (MapPoint point : map.points) {
    point.p_map += Vector3d(3, 15, 0);
    points.push_back(point);
  }
  map.points = points;
  EXPECT_FALSE(find_place(s.seen, s.p_camera, map));
}

}  // namespace
}  // namespace chasles
