#include <cmath>

#include <chasles/loop/run_in_map_testing.hpp>
#include <chasles/loop/saved_map.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

const Time kEnd = from_seconds(50), kLeft = from_seconds(20);

// What the run knows of its landmarks' appearance, all of them seen from 3 m.
struct Mapped {
  explicit Mapped(std::uint64_t seed) : run(seed), placed(run.placed) {
    for (const int point : {0, 2, 4, 5}) note_left(kFirstMapId + point, run.number_of(point));
    for (const auto& [id, number] : run.left) note_left(id, number);
    for (const Landmark& landmark : run.filter.state().landmarks) {
      appearances[landmark.id].add(view_of(landmark.id));
    }
  }

  PatchView view_of(LandmarkId id) {
    return id < kFirstMapId
               ? test::random_view(run.random, run.nav_T_map.R * Vector3d(-3, -0.4, 0))
               : run.map->points[run.index(id)].appearance.turned(run.nav_T_map.R).views().front();
  }

  void note_left(LandmarkId id, int number) {
    PastLandmark& landmark = past[id];
    landmark = {
        .number = number, .p_nav = run.position(id, VectorXd::Zero(run.P.rows())), .left = kLeft};
    landmark.appearance.add(view_of(id));
  }

  LandmarkMap saved(std::optional<Time> until = std::nullopt, int most = 100) const {
    return saved_map(
        {.filter = run.filter, .past = past, .appearances = appearances, .placed = placed},
        test::inertial_cameras(), most, kEnd, until);
  }

  test::RunInMap run;
  PastLandmarks past;
  std::map<LandmarkId, Appearance> appearances;
  std::optional<PlacedMap> placed;
};

std::vector<int> sessions(const LandmarkMap& map) {
  std::vector<int> result;
  for (const MapPoint& point : map.points) result.push_back(point.session);
  return result;
}

/// The positions of these landmarks in the frame of the map, or in nav.
VectorXd positions(const Mapped& x, const std::vector<LandmarkId>& ids, const VectorXd& e) {
  const SE3 map_T_nav = x.placed ? x.run.frame(e).inverse() : SE3{};
  VectorXd all(3 * std::ssize(ids));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = map_T_nav * x.run.position(ids[i], e);
  }
  return all;
}

// Root mean square of the correlations of two points that differ.
double difference_of_pairs(const MatrixXd& actual, const MatrixXd& expected) {
  const VectorXd scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  MatrixXd difference = scale.asDiagonal() * (actual - expected) * scale.asDiagonal();
  for (Eigen::Index i = 0; i < difference.rows(); i += 3) difference.block<3, 3>(i, i).setZero();
  const auto n = static_cast<double>(difference.rows());
  return difference.norm() / std::sqrt(n * (n - 3));
}

// The map's points that have not returned, then those that left, then those of the state. Their
// joint covariance in the frame of the map is that of the textbook filter, by numeric derivatives;
// two reductions leave out correlations of 0.003 each.
TEST(SavedMap, OfARunInAMapHasTheMeanAndCovarianceOfTheTextbookFilter) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Mapped x(seed);
    const std::vector<LandmarkId> ids{
        kFirstMapId, kFirstMapId + 2, kFirstMapId + 4, kFirstMapId + 5, 7, kFirstMapId + 1, 8,
        9,           kFirstMapId + 3};
    const LandmarkMap map = x.saved();
    ASSERT_EQ(map.points.size(), ids.size());
    EXPECT_EQ(sessions(map), (std::vector{0, 0, 0, 0, 1, 0, 1, 1, 0}));
    const VectorXd zero = VectorXd::Zero(x.run.P.rows());
    const VectorXd expected = positions(x, ids, zero);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const Vector3d at = expected.segment<3>(3 * static_cast<Eigen::Index>(i));
      EXPECT_LT((map.points[i].p_map - at).norm(), i < 4 ? 1e-4 : 1e-9) << ids[i];
    }
    const MatrixXd J = test::numeric_derivative(
        [&](const VectorXd& e) { return positions(x, ids, e); }, zero, 1e-4);
    const MatrixXd P = J * x.run.P * J.transpose();
    EXPECT_LT(difference_of_pairs(test::whole_covariance(map.covariance), P), 0.006);
    for (int i = 0; i < static_cast<int>(ids.size()); ++i) {
      const MatrixXd own = P.block<3, 3>(3 * i, 3 * i);
      EXPECT_LT(test::covariance_difference(map.covariance.of(i), own), 1e-3) << ids[i];
    }
  }
}

TEST(SavedMap, NamesTheRunsAndKeepsTheirPoints) {
  const Mapped x(1);
  const LandmarkMap map = x.saved();
  ASSERT_EQ(map.sessions.size(), 2u);
  EXPECT_EQ(map.sessions.front().name, x.run.map->sessions.front().name);
  EXPECT_EQ(map.sessions.back().end, kEnd);
  EXPECT_EQ(map.sessions.back().cameras.size(), test::inertial_cameras().size());
  EXPECT_EQ(map.points.front().observations, x.run.map->points.front().observations);
  EXPECT_EQ(map.points.back().observations, x.run.map->points[3].observations + 2);
  EXPECT_EQ(map.points[6].observations, 23) << "8, at its begin 20 and observed three times";
  // The views are upright, and their directions in the frame of the map.
  const PatchView& before = x.run.map->points[2].appearance.views().front();
  const PatchView& after = map.points[1].appearance.views().front();
  EXPECT_EQ(before.descriptors, after.descriptors);
  EXPECT_LT((before.from - after.from).norm(), 0.02);
}

// Without a map the frame is nav, and so it is saved.
TEST(SavedMap, OfARunOfItsOwnIsInNav) {
  Mapped x(2);
  x.placed.reset();
  for (const int point : {0, 2, 4, 5}) x.past.erase(kFirstMapId + point);
  for (const int point : {1, 3}) {
    x.past.erase(kFirstMapId + point);
    x.appearances.erase(kFirstMapId + point);
  }
  const LandmarkMap map = x.saved();
  const std::vector<LandmarkId> ids{7, 8, 9};
  ASSERT_EQ(map.points.size(), ids.size());
  EXPECT_EQ(map.sessions.size(), 1u);
  const VectorXd zero = VectorXd::Zero(x.run.P.rows()), expected = positions(x, ids, zero);
  MatrixXd J(9, x.run.P.cols());
  for (Eigen::Index i = 0; i < 3; ++i) {
    J.middleRows<3>(3 * i) = x.run.by_errors(ids[static_cast<std::size_t>(i)]);
    const Vector3d& at = map.points[static_cast<std::size_t>(i)].p_map;
    EXPECT_LT((at - expected.segment<3>(3 * i)).norm(), 1e-9);
  }
  const MatrixXd P = J * x.run.P * J.transpose();
  EXPECT_LT(difference_of_pairs(test::whole_covariance(map.covariance), P), 0.006);
}

TEST(SavedMap, LeavesOutWhatCannotBeRecognised) {
  const auto size_with = [](const auto& change) {
    Mapped x(3);
    change(x);
    return x.saved().points.size();
  };
  EXPECT_EQ(size_with([](Mapped&) {}), 9u);
  EXPECT_EQ(size_with([](Mapped& x) { x.appearances.erase(8); }), 8u);
  EXPECT_EQ(size_with([](Mapped& x) { x.past[7].appearance = {}; }), 8u);
  EXPECT_EQ(size_with([](Mapped& x) {  // from above, upright by other axes
              x.past[7].appearance = {};
              x.past[7].appearance.add(test::random_view(x.run.random, {0.1, 0, 3}));
            }),
            8u);
  EXPECT_EQ(size_with([](Mapped& x) {
              NewLandmark young;
              young.id = 10;
              young.p_world = Vector3d(20, 20, 0);
              young.noise = Eigen::Matrix3d::Identity();
              young.observations = 9;
              x.run.filter.add({&young, 1});
              x.appearances[10].add(test::random_view(x.run.random, {-3, 0, 0}));
            }),
            9u)
      << "observed nine times";
  EXPECT_EQ(size_with([](Mapped& x) {
              x.past[7].p_nav = x.past.at(kFirstMapId + 2).p_nav;
              x.past[7].appearance = x.past.at(kFirstMapId + 2).appearance;
            }),
            8u)
      << "a point of the map is there";
}

// Of the run's own landmarks, 7 alone has left.
TEST(SavedMap, UntilATimeHasOwnLandmarksThatLeftBefore) {
  const Mapped x(3);
  EXPECT_EQ(sessions(x.saved(kLeft + Time(1))), (std::vector{0, 0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(sessions(x.saved(kLeft)), (std::vector{0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace chasles
