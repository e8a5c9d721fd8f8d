#include <algorithm>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/loop/extension_testing.hpp>
#include <chasles/loop/map_extensions.hpp>
#include <chasles/loop/map_family.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::MapOfTruth;

// Two runs that began in one map, and went on from it into the same new corridor, or into two.
struct Extended {
  LandmarkMap truth = test::corridor_map(7, 120, 30);
  MapOfTruth base, a, b;

  explicit Extended(std::uint64_t seed, bool same_way = true) {
    test::Random random(seed);
    base.map = test::walk_map(truth, 10, 20, {}, 1, random, &base.indices);
    a = test::extended_map(base, truth, 13, 30, 2, random);
    b = test::extended_map(base, truth, same_way ? 13 : 0, same_way ? 30 : 17, 3, random);
  }
  std::vector<MapPart> parts() const { return {{"a", a.map}, {"b", b.map}}; }
};

double nees_of(const LandmarkMap& map, const LandmarkMap& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    double least = 1e9;
    for (const MapPoint& t : truth.points) {
      least = std::min(least, (t.p_map - map.points[i].p_map).squaredNorm());
    }
    sum += least / map.covariance.of(static_cast<int>(i)).trace();
  }
  return sum / static_cast<double>(map.points.size());
}

TEST(MapExtensions, HaveTheSessionsAndTheLandmarksOfTheirMap) {
  const Extended e(1);
  EXPECT_TRUE(extends(e.a.map, e.base.map));
  EXPECT_FALSE(extends(e.base.map, e.a.map));
  EXPECT_FALSE(extends(e.base.map, e.base.map));
  EXPECT_FALSE(extends(e.a.map, e.b.map));
  const std::vector<int> of_base = points_of(e.base.map, e.a.map);
  for (std::size_t i = 0; i < of_base.size(); ++i) {
    const bool is_of_base = i < e.base.map.points.size();
    EXPECT_EQ(of_base[i], is_of_base ? static_cast<int>(i) : -1);
  }
}

TEST(MapExtensions, NothingIsLostAndNothingCountsTwice) {
  const Extended e(2);
  const LandmarkMap both = joined_extensions(e.base.map, e.parts());
  ASSERT_EQ(both.sessions.size(), 3u);
  EXPECT_EQ(both.sessions[0].name, "walk-1");
  EXPECT_EQ(both.sessions[1].name, "run-2");
  EXPECT_EQ(both.sessions[2].name, "run-3");
  const std::size_t n_0 = e.base.map.points.size(), n_a = e.a.map.points.size();
  const std::size_t fresh = n_a - n_0;  // both runs saw all of them
  EXPECT_GE(both.points.size(), n_a);
  EXPECT_LT(both.points.size(), n_a + fresh / 2);
  for (std::size_t i = 0; i < n_0; ++i) {
    EXPECT_EQ(both.points[i].session, 0);
    EXPECT_EQ(both.points[i].observations, e.base.map.points[i].observations + 10);
  }
  for (std::size_t i = n_0; i < both.points.size(); ++i) {
    EXPECT_GE(both.points[i].session, 1) << i;
    EXPECT_LE(both.points[i].session, 2) << i;
  }
  EXPECT_TRUE(
      is_same_map(joined_extensions(e.base.map, std::vector<MapPart>{{"a", e.a.map}}), e.a.map));
}

// Half of each information on the landmarks of base, and all of the others' given them: written
// out.
TEST(MapExtensions, IsTheIntersectionOfCovariances) {
  const Extended e(3, false);  // without further matches
  const LandmarkMap both = joined_extensions(e.base.map, e.parts());
  const auto n_0 = 3 * static_cast<Index>(e.base.map.points.size());
  const auto n_a = 3 * static_cast<Index>(e.a.map.points.size()) - n_0,
             n_b = 3 * static_cast<Index>(e.b.map.points.size()) - n_0, n = n_0 + n_a + n_b;
  ASSERT_EQ(3 * static_cast<Index>(both.points.size()), n);
  MatrixXd information = MatrixXd::Zero(n, n);
  VectorXd right = VectorXd::Zero(n);
  const auto add = [&](const LandmarkMap& map, Index first, Index size) {
    MatrixXd P = test::whole_covariance(map.covariance);
    MatrixXd I = P.llt().solve(MatrixXd::Identity(P.rows(), P.rows()));
    const MatrixXd of_base = P.topLeftCorner(n_0, n_0).llt().solve(MatrixXd::Identity(n_0, n_0));
    I.topLeftCorner(n_0, n_0) -= of_base / 2;
    std::vector<Index> rows;
    for (Index i = 0; i < n_0; ++i) rows.push_back(i);
    for (Index i = 0; i < size; ++i) rows.push_back(first + i);
    information(rows, rows) += I;
    right(rows) += I * test::positions(map);
  };
  add(e.a.map, n_0, n_a);
  add(e.b.map, n_0 + n_a, n_b);
  const MatrixXd P = information.llt().solve(MatrixXd::Identity(n, n));
  const VectorXd mean = P * right;
  for (Index i = 0; i < n / 3; ++i) {
    const Eigen::Matrix3d expected = P.block<3, 3>(3 * i, 3 * i);
    const Eigen::Matrix3d found = both.covariance.of(static_cast<int>(i));
    const double sigma = std::sqrt(expected.trace());
    // Never less certain by much, and never more certain.
    EXPECT_GT(found.trace(), 0.99 * expected.trace()) << i;
    EXPECT_LT(found.trace(), 1.25 * expected.trace()) << i;
    EXPECT_LT((both.points[static_cast<std::size_t>(i)].p_map - mean.segment<3>(3 * i)).norm(),
              0.25 * sigma)
        << i;
  }
}

TEST(MapExtensions, IsConsistentAndBetterThanTheMap) {
  double of_base = 0, of_a = 0, of_both = 0, trace_a = 0, trace_both = 0;
  constexpr int kSeeds = 12;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Extended e(10 + seed);
    const LandmarkMap both = joined_extensions(e.base.map, e.parts());
    of_base += nees_of(e.base.map, e.truth) / kSeeds;
    of_a += nees_of(e.a.map, e.truth) / kSeeds;
    of_both += nees_of(both, e.truth) / kSeeds;
    for (int i = 0; i < static_cast<int>(e.a.map.points.size()); ++i) {
      trace_a += e.a.map.covariance.of(i).trace();
      trace_both += both.covariance.of(i).trace();
    }
  }
  EXPECT_LT(of_both, 1.3) << of_base << " " << of_a;
  EXPECT_GT(of_both, 0.3);
  EXPECT_LT(trace_both, trace_a);
}

TEST(MapExtensions, OfAnotherMapIsRejected) {
  const Extended e(4);
  const auto rejection = [&](const LandmarkMap& other) -> std::string {
    try {
      joined_extensions(e.base.map, std::vector<MapPart>{{"a", e.a.map}, {"b", other}});
    } catch (const InputError& error) {
      return error.what();
    }
    return "joined";
  };
  EXPECT_EQ(rejection(e.b.map), "joined");
  LandmarkMap moved = e.b.map;
  for (MapPoint& point : moved.points) point.p_map.y() += 5;
  EXPECT_EQ(rejection(moved).find("b: contradicts the other runs"), 0u) << rejection(moved);
  test::Random random(5);
  LandmarkMap foreign = test::walk_map(test::corridor_map(9, 120, 30), 10, 20, {}, 1, random);
  foreign.sessions.push_back({.name = "x", .begin = Time(900), .end = Time(901), .cameras = {}});
  EXPECT_EQ(rejection(foreign).find("b: found 0 of the "), 0u) << rejection(foreign);
}

}  // namespace
}  // namespace chasles
