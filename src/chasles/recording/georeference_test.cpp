#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <chasles/recording/georeference.hpp>

namespace chasles {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const Georeference kKarlsruhe{{.latitude = 49.011, .longitude = 8.423, .altitude = 116}};

TEST(Georeference, TheOriginIsZero) {
  EXPECT_EQ(to_world(kKarlsruhe, kKarlsruhe.origin), Eigen::Vector3d::Zero());
}

TEST(Georeference, ASmallStepIsAnArcOfTheSphere) {
  const double step = 1e-4;  // [deg], 11 m
  const Geodetic o = kKarlsruhe.origin;
  const double arc = 6378137 * step * kDegree;
  const Eigen::Vector3d north = to_world(
      kKarlsruhe, {.latitude = o.latitude + step, .longitude = o.longitude, .altitude = 120});
  EXPECT_NEAR(north.x(), 0, 1e-9);
  EXPECT_NEAR(north.y(), arc, 1e-4);
  EXPECT_NEAR(north.z(), 4, 1e-12);
  const Eigen::Vector3d east = to_world(
      kKarlsruhe, {.latitude = o.latitude, .longitude = o.longitude + step, .altitude = 116});
  EXPECT_NEAR(east.x(), arc * std::cos(o.latitude * kDegree), 1e-8);
  EXPECT_NEAR(east.y(), 0, 1e-9);
}

TEST(Georeference, ThereAndBackIsTheSamePlace) {
  for (const double north : {-3000.0, 0.0, 4500.0}) {
    for (const double east : {-7000.0, 12.5}) {
      const Eigen::Vector3d p(east, north, -3);
      const Geodetic place = to_geodetic(kKarlsruhe, p);
      EXPECT_LT((to_world(kKarlsruhe, place) - p).norm(), 1e-7);
      // Within about a kilometre the sphere's own latitude and longitude agree closely.
      EXPECT_NEAR(place.latitude, 49.011 + north / 6378137 / kDegree, 5e-5);
    }
  }
}

}  // namespace
}  // namespace chasles
