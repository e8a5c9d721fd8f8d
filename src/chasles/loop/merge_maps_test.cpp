#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/random_ekf_testing.hpp>
#include <chasles/loop/map_testing.hpp>
#include <chasles/loop/merge_maps.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Match = PlaceInMap::Match;

// Two walks through a corridor that overlap.
struct Walks {
  LandmarkMap truth, a, b;
  std::vector<int> of_a, of_b;
  SE3 a_T_b = test::level_pose(1.1, {4, 5, -1});
  std::vector<Match> matches;
};

Walks two_walks(std::uint64_t seed) {
  test::Random random(seed);
  Walks w;
  w.truth = test::corridor_map(7, 160, 40);
  w.a = test::walk_map(w.truth, 0, 25, {}, 1, random, &w.of_a);
  w.b = test::walk_map(w.truth, 15, 40, w.a_T_b.inverse(), 2, random, &w.of_b);
  for (std::size_t j = 0; j < w.of_b.size(); ++j) {
    const auto i = std::ranges::find(w.of_a, w.of_b[j]);
    if (i == w.of_a.end()) continue;
    w.matches.push_back({static_cast<int>(j), static_cast<int>(i - w.of_a.begin())});
  }
  return w;
}

// The Kalman filter of both maps and the place, with all covariances written out. The place is
// known to 5 m before and to millimetres after: with double precision, too few digits would remain.
struct Dense {
  VectorXd mean;  // of a's points, then b's, in a's frame
  MatrixXd P;
};
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

Dense dense_merge(const Walks& w) {
  const Index n_a = 3 * static_cast<Index>(w.a.points.size()),
              n_b = 3 * static_cast<Index>(w.b.points.size());
  Dense result{.mean = VectorXd(n_a + n_b), .P = MatrixXd::Zero(n_a + n_b, n_a + n_b)};
  for (std::size_t i = 0; i < w.a.points.size(); ++i) {
    result.mean.segment<3>(3 * static_cast<Index>(i)) = w.a.points[i].p_map;
  }
  result.P.topLeftCorner(n_a, n_a) = test::whole_covariance(w.a.covariance);
  MatrixXd R = MatrixXd::Zero(n_b, n_b), J(n_b, 4);
  Vector3d pivot = Vector3d::Zero();
  for (const Match& match : w.matches) {
    pivot += w.a_T_b * w.b.points[static_cast<std::size_t>(match.seen)].p_map /
             static_cast<double>(w.matches.size());
  }
  for (std::size_t i = 0; i < w.b.points.size(); ++i) {
    const Index at = 3 * static_cast<Index>(i);
    const Vector3d p = w.a_T_b * w.b.points[i].p_map;
    result.mean.segment<3>(n_a + at) = p;
    R.block<3, 3>(at, at) = w.a_T_b.R;
    J.block<3, 1>(at, 0) = 0.3 * Vector3d::UnitZ().cross(p - pivot);
    J.block<3, 3>(at, 1) = 5 * Eigen::Matrix3d::Identity();
  }
  result.P.bottomRightCorner(n_b, n_b) =
      R * test::whole_covariance(w.b.covariance) * R.transpose() + J * J.transpose();
  const auto m = 3 * static_cast<Index>(w.matches.size());
  MatrixXd H = MatrixXd::Zero(m, n_a + n_b), noise = MatrixXd::Zero(m, m);
  for (std::size_t k = 0; k < w.matches.size(); ++k) {
    const Index row = 3 * static_cast<Index>(k);
    H.block<3, 3>(row, n_a + 3 * w.matches[k].seen).setIdentity();
    H.block<3, 3>(row, 3 * w.matches[k].point).diagonal().setConstant(-1);
    const MapPoint& point = w.a.points[static_cast<std::size_t>(w.matches[k].point)];
    const double pixel = 1.5e-3 * std::exp2(point.appearance.views().front().level / 2.0);
    noise.block<3, 3>(row, row).diagonal().setConstant(pixel * pixel);
  }
  const LongMatrix P = result.P.cast<long double>(), H_long = H.cast<long double>();
  const LongMatrix PH = P * H_long.transpose();
  const LongMatrix S = H_long * PH + noise.cast<long double>();
  const LongMatrix K = S.ldlt().solve(PH.transpose()).transpose();
  result.mean -= (K * H_long * result.mean.cast<long double>()).cast<double>();
  result.P = (P - K * PH.transpose()).cast<double>();
  return result;
}

TEST(MergeMaps, IsTheKalmanFilterOfBothMaps) {
  const Walks w = two_walks(1);
  const Dense dense = dense_merge(w);
  const JoinedMaps merged = join_maps(w.a, w.b, w.a_T_b, w.matches);
  const auto n_a = static_cast<Index>(w.a.points.size());
  ASSERT_EQ(merged.map.points.size(), w.a.points.size() + w.b.points.size() - w.matches.size());
  std::vector<Index> rows;
  for (Index i = 0; i < 3 * n_a; ++i) rows.push_back(i);
  for (std::size_t j = 0; j < w.b.points.size(); ++j) {
    if (std::ranges::find(w.matches, static_cast<int>(j), &Match::seen) != w.matches.end())
      continue;
    for (Index i = 0; i < 3; ++i) rows.push_back(3 * n_a + 3 * static_cast<Index>(j) + i);
  }
  for (std::size_t i = 0; i < merged.map.points.size(); ++i) {
    const Vector3d expected = dense.mean(rows).segment<3>(3 * static_cast<Index>(i));
    EXPECT_LT((merged.map.points[i].p_map - expected).norm(), 1e-9) << i;
  }
  // Sixteen directions are shared: those of both walks, and the place.
  const MatrixXd P = dense.P(rows, rows), Q = test::whole_covariance(merged.map.covariance);
  const VectorXd sigma = P.diagonal().cwiseSqrt();
  const MatrixXd error = (P - Q).cwiseQuotient(sigma * sigma.transpose());
  EXPECT_LT(std::sqrt(error.squaredNorm() / static_cast<double>(error.size())), 0.003);
  for (Index i = 0; i < P.rows(); i += 3) {
    EXPECT_TRUE(test::agree(P.block<3, 3>(i, i), Q.block<3, 3>(i, i), 1e-9, 0)) << i;
  }
}

// Mean squared distance of some of the points from the nearest true one, by its variance.
double nees(const LandmarkMap& map, std::size_t first, const LandmarkMap& truth) {
  double sum = 0;
  int numbers = 0;
  for (std::size_t i = first; i < map.points.size(); i += 7) {
    double least = 1e9;
    for (const MapPoint& t : truth.points) {
      least = std::min(least, (t.p_map - map.points[i].p_map).norm());
    }
    sum += least * least / map.covariance.of(static_cast<int>(i)).trace();
    ++numbers;
  }
  return sum / numbers;
}

TEST(MergeMaps, FindsThePlaceAndIsConsistent) {
  double sum = 0, nis = 0;
  int differences = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Walks w = two_walks(seed);
    const MergedMaps merged = merge_maps({{"a", w.a}, {"b", w.b}});
    ASSERT_EQ(merged.joined.size(), 1u);
    const MergedMaps::Joined& joined = merged.joined.front();
    EXPECT_GT(joined.matches, static_cast<int>(w.matches.size()) / 2);
    EXPECT_LE(joined.matches, static_cast<int>(w.matches.size()));
    nis += joined.nis;
    differences += 3 * joined.matches;
    ASSERT_EQ(merged.map.sessions.size(), 2u);
    // Points of b alone, against the truth in a's frame: a's own errors remain.
    EXPECT_EQ(merged.map.points[w.a.points.size()].session, 1);
    sum += nees(merged.map, w.a.points.size(), w.truth);
  }
  EXPECT_LT(sum / 10, 1.6);
  EXPECT_GT(sum / 10, 0.4);
  EXPECT_LT(nis / differences, 1.3);
  EXPECT_GT(nis / differences, 0.6);
}

bool identical(const LandmarkMap& a, const LandmarkMap& b) {
  const auto same_point = [](const MapPoint& x, const MapPoint& y) {
    const auto same_view = [](const PatchView& v, const PatchView& w) {
      return v.from == w.from && v.level == w.level && v.descriptors == w.descriptors;
    };
    return x.p_map == y.p_map && x.session == y.session && x.observations == y.observations &&
           std::ranges::equal(x.appearance.views(), y.appearance.views(), same_view);
  };
  return std::ranges::equal(a.sessions, b.sessions, {}, &MapSession::name, &MapSession::name) &&
         std::ranges::equal(a.points, b.points, same_point) &&
         a.covariance.own() == b.covariance.own() && a.covariance.rank() == b.covariance.rank() &&
         a.covariance.shared() == b.covariance.shared();
}

// The third walk sees no place of the first one: it is joined after the second.
std::vector<MapPart> three_walks(const LandmarkMap& truth, std::uint64_t seed) {
  test::Random random(seed);
  return {{"a", test::walk_map(truth, 0, 25, {}, 1, random)},
          {"c", test::walk_map(truth, 35, 60, test::level_pose(-2, {1, 2, 3}), 2, random)},
          {"b", test::walk_map(truth, 15, 45, test::level_pose(1, {-4, 2, 0}), 3, random)}};
}

TEST(MergeMaps, InAnyOrderIsTheSameMap) {
  const LandmarkMap truth = test::corridor_map(7, 240, 60);
  const std::vector<MapPart> parts = three_walks(truth, 3);
  const MergedMaps expected = merge_maps(parts);
  ASSERT_EQ(expected.joined.size(), 2u);
  EXPECT_EQ(expected.joined[0].sessions[0].name, "walk-3");
  EXPECT_EQ(expected.joined[1].sessions[0].name, "walk-2");
  EXPECT_EQ(expected.map.sessions[0].name, "walk-1");
  std::vector<int> order{0, 1, 2};
  do {
    std::vector<MapPart> ordered;
    for (const int i : order) ordered.push_back(parts[static_cast<std::size_t>(i)]);
    EXPECT_TRUE(identical(merge_maps(ordered).map, expected.map));
  } while (std::ranges::next_permutation(order).found);
  // Merged maps are merged by their parts; one that both have counts once.
  const auto merged_parts = [](const MergedMaps& merged) {
    std::vector<MapPart> again;
    for (const LandmarkMap& part : merged.parts) again.push_back({"merged", part});
    return again;
  };
  const std::vector<MapPart> ab = merged_parts(merge_maps({parts[0], parts[2]})),
                             bc = merged_parts(merge_maps({parts[2], parts[1]}));
  ASSERT_EQ(ab.size(), 2u);
  EXPECT_TRUE(identical(merge_maps({ab[0], parts[1], ab[1]}).map, expected.map));
  EXPECT_TRUE(identical(merge_maps({bc[0], bc[1], parts[0]}).map, expected.map));
  const MergedMaps twice = merge_maps({bc[0], ab[1], bc[1], ab[0]});
  EXPECT_TRUE(identical(twice.map, expected.map));
  EXPECT_EQ(twice.parts.size(), 3u);
}

TEST(MergeMaps, ThreeWalksAreConsistent) {
  const LandmarkMap truth = test::corridor_map(7, 240, 60);
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    sum += nees(merge_maps(three_walks(truth, seed)).map, 0, truth);
  }
  EXPECT_LT(sum / 10, 1.6);
  EXPECT_GT(sum / 10, 0.4);
}

TEST(MergeMaps, OnePartIsTheMapItself) {
  const LandmarkMap a = two_walks(1).a;
  const MergedMaps merged = merge_maps({{"a", a}, {"copy", a}});
  EXPECT_TRUE(identical(merged.map, a));
  EXPECT_TRUE(merged.parts.empty());
  EXPECT_TRUE(merged.joined.empty());
}

TEST(MergeMaps, RejectsWhatIsNotWalksInOnePlace) {
  const Walks w = two_walks(1);
  const auto message = [](std::vector<MapPart> parts) -> std::string {
    try {
      merge_maps(std::move(parts));
    } catch (const InputError& error) {
      return error.what();
    }
    return "merged";
  };
  // As a run in the map a would leave it.
  LandmarkMap extended = w.a;
  extended.sessions.push_back({.name = "later", .begin = Time(90), .end = Time(95), .cameras = {}});
  extended.points.pop_back();
  extended.covariance = JointCovariance(
      {w.a.covariance.own().begin(), w.a.covariance.own().end() - 1},
      w.a.covariance.shared().topRows(3 * static_cast<Index>(extended.points.size())));
  EXPECT_EQ(message({{"b", w.b}, {"more", extended}}), "merged");
  EXPECT_NE(message({{"a", w.a}, {"b", w.b}, {"more", extended}})
                .find("a and more: different maps with a session of the recording walk-1: merging "
                      "them would count it twice"),
            std::string::npos);
  test::Random random(8);
  const LandmarkMap other = test::walk_map(test::corridor_map(8, 160, 40), 0, 40, {}, 3, random);
  const std::string expected = "other: no place in common with a, b: found ";
  EXPECT_EQ(message({{"other", other}, {"b", w.b}, {"a", w.a}}).find(expected), 0u)
      << message({{"other", other}, {"b", w.b}, {"a", w.a}});
  EXPECT_EQ(message({{"a", w.a}, {"other", other}, {"b", w.b}}),
            message({{"other", other}, {"b", w.b}, {"a", w.a}}));
  EXPECT_NE(message({{"b", w.b}, {"empty", {}}}).find("no place in common"), std::string::npos);
  EXPECT_THROW(merge_maps({}), UsageError);
}

}  // namespace
}  // namespace chasles
