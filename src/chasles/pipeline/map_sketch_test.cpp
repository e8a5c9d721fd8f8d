#include <gtest/gtest.h>

#include <chasles/loop/map_testing.hpp>
#include <chasles/pipeline/map_sketch.hpp>

namespace chasles {
namespace {

TEST(MapSketch, HasWhatIsShownOfAMap) {
  const LandmarkMap map = test::corridor_map(2, 20, 10);
  const MapSketch sketch = map_sketch(map);
  ASSERT_EQ(sketch.sessions.size(), 1u);
  EXPECT_EQ(sketch.sessions[0].name, "corridor");
  ASSERT_EQ(sketch.points.size(), map.points.size());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const SketchPoint& point = sketch.points[i];
    const int index = static_cast<int>(i);
    EXPECT_EQ(point.id, kFirstMapId + index);
    EXPECT_EQ(point.p_map, map.points[i].p_map);
    EXPECT_EQ(point.covariance, map.covariance.of(index));
    const double shared = map.covariance.shared().middleRows<3>(3 * index).squaredNorm();
    EXPECT_NEAR((1 - point.own) * point.covariance.trace(), shared, 1e-12);
  }
}

}  // namespace
}  // namespace chasles
