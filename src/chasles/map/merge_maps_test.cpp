#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/error.hpp>
#include <chasles/filter/random_ekf_testing.hpp>
#include <chasles/map/map_testing.hpp>
#include <chasles/map/merge_maps.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Match = PlaceInMap::Match;

// Errors drawn from the map's covariance move its points.
LandmarkMap with_errors(LandmarkMap map, test::Random& random) {
  const VectorXd y = random.normal_vector(map.covariance.rank());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const auto index = static_cast<Index>(i);
    const double own = std::sqrt(map.covariance.own()[i](0, 0));
    map.points[i].p_map +=
        map.covariance.shared().middleRows<3>(3 * index) * y + own * random.normal_vector(3);
  }
  return map;
}

// A map in another frame.
LandmarkMap moved(LandmarkMap map, const SE3& new_T_old) {
  std::vector<Eigen::Matrix3d> own;
  MatrixXd shared = map.covariance.shared();
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    MapPoint& point = map.points[i];
    point.p_map = new_T_old * point.p_map;
    point.appearance = point.appearance.turned(new_T_old.R);
    auto rows = shared.middleRows<3>(3 * static_cast<Index>(i));
    rows = (new_T_old.R * rows).eval();
    own.emplace_back(new_T_old.R * map.covariance.own()[i] * new_T_old.R.transpose());
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared));
  return map;
}

// Some points of a corridor, and their indices.
LandmarkMap part(const LandmarkMap& map, double from, double to, std::vector<int>& indices) {
  LandmarkMap result{.sessions = map.sessions, .points = {}, .covariance = {}};
  indices.clear();
  std::vector<Eigen::Matrix3d> own;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const double x = map.points[i].p_map.x();
    if (x < from || x > to) continue;
    indices.push_back(static_cast<int>(i));
    result.points.push_back(map.points[i]);
    own.push_back(map.covariance.own()[i]);
  }
  MatrixXd shared(3 * static_cast<Index>(own.size()), map.covariance.rank());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    shared.middleRows<3>(3 * static_cast<Index>(i)) =
        map.covariance.shared().middleRows<3>(3 * indices[i]);
  }
  result.covariance = JointCovariance(std::move(own), std::move(shared));
  return result;
}

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
  w.a = with_errors(part(w.truth, 0, 25, w.of_a), random);
  LandmarkMap b = with_errors(part(w.truth, 15, 40, w.of_b), random);
  for (MapPoint& point : b.points) {
    Appearance again;
    again.add(test::seen_again(random, point.appearance.views().front(), 20));
    point.appearance = again;
  }
  b.sessions.front().name = "again";
  w.b = moved(b, w.a_T_b.inverse());
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
  const MergedMaps merged = merge_maps(w.a, w.b, w.a_T_b, w.matches);
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

TEST(MergeMaps, FindsThePlaceAndIsConsistent) {
  double nees = 0, nis = 0;
  int numbers = 0, differences = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Walks w = two_walks(seed);
    const MergedMaps merged = merge_maps(w.a, w.b);
    EXPECT_GT(merged.matches, static_cast<int>(w.matches.size()) / 2);
    EXPECT_LE(merged.matches, static_cast<int>(w.matches.size()));
    nis += merged.nis;
    differences += 3 * merged.matches;
    ASSERT_EQ(merged.map.sessions.size(), 2u);
    // Points of b alone, against the truth in a's frame: a's own errors remain.
    for (std::size_t i = w.a.points.size(); i < merged.map.points.size(); i += 7) {
      const MapPoint& point = merged.map.points[i];
      EXPECT_EQ(point.session, 1);
      double least = 1e9;
      for (const MapPoint& t : w.truth.points) {
        least = std::min(least, (t.p_map - point.p_map).norm());
      }
      const double variance = merged.map.covariance.of(static_cast<int>(i)).trace();
      nees += least * least / variance;
      ++numbers;
    }
  }
  EXPECT_LT(nees / numbers, 1.6);
  EXPECT_GT(nees / numbers, 0.4);
  EXPECT_LT(nis / differences, 1.3);
  EXPECT_GT(nis / differences, 0.6);
}

// Distances between points do not depend on the frame.
TEST(MergeMaps, InEitherOrderIsTheSameMap) {
  const Walks w = two_walks(3);
  const MergedMaps ab = merge_maps(w.a, w.b), ba = merge_maps(w.b, w.a);
  EXPECT_EQ(ab.matches, ba.matches);
  EXPECT_NEAR(ab.nis, ba.nis, 1e-3 * ab.nis);
  ASSERT_EQ(ab.map.points.size(), ba.map.points.size());
  const SE3 b_T_a = ba.a_T_b;
  for (const MapPoint& point : ab.map.points) {
    double least = 1e9;
    for (const MapPoint& other : ba.map.points) {
      least = std::min(least, (b_T_a * point.p_map - other.p_map).norm());
    }
    EXPECT_LT(least, 0.02);
  }
}

TEST(MergeMaps, RefusesWhatIsNotTwoWalksInOnePlace) {
  const Walks w = two_walks(1);
  const auto message = [](const LandmarkMap& a, const LandmarkMap& b) -> std::string {
    try {
      merge_maps(a, b);
    } catch (const InputError& error) {
      return error.what();
    }
    return "merged";
  };
  EXPECT_NE(message(w.a, w.a).find("count it twice"), std::string::npos);
  LandmarkMap other = test::corridor_map(8, 160, 40);
  EXPECT_NE(message(w.b, other).find("no place in common"), std::string::npos);
  EXPECT_NE(message(w.b, {}).find("no place in common"), std::string::npos);
}

}  // namespace
}  // namespace chasles
