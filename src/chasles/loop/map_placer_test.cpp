#include <algorithm>
#include <chrono>

#include <Eigen/LU>

#include <chasles/filter/inertial_testing.hpp>
#include <chasles/loop/map_placer.hpp>
#include <chasles/loop/map_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPixelSigma = 1;  // [px]

// A camera at x = 7 m in the corridor of a map. It observes `known` of the map's points, and
// `others` that are not in the map; all are landmarks of its filter. The errors of the filter, of
// the map and of the pixels are drawn from their covariances.
struct InTheCorridor {
  InTheCorridor(std::uint64_t seed, int known, int others = 0)
      : random(seed), filter(some_filter(random, nav_T_imu(), seed % 2 == 0)) {
    const VectorXd drift = random.normal_vector(map->covariance.rank());
    for (int i = 55; std::ssize(points) < known; i += 3) {
      const MapPoint& point = map->points[static_cast<std::size_t>(i)];
      const Matrix3d& own = map->covariance.own()[static_cast<std::size_t>(i)];
      const Vector3d p_map = point.p_map + map->covariance.shared().middleRows<3>(3 * i) * drift +
                             test::normal_of(random, own);
      PatchView view = test::seen_again(random, point.appearance.views().front(), 20);
      view.from = nav_T_map.R.cast<float>() * view.from;
      observe(nav_T_imu().inverse() * nav_T_map * p_map, view);
      points.push_back(i);
    }
    for (int i = 0; i < others; ++i) {
      const Vector3d p_imu = test::point_ahead(random, 5);
      observe(p_imu, test::random_view(random, nav_T_imu().R * -p_imu));
      points.push_back(-1);
    }
  }

  SE3 nav_T_imu() const { return nav_T_map * SE3{Matrix3d::Identity(), {7, 0.2, 0.1}}; }

  Surroundings here() const {
    return {.filter = filter,
            .cameras = cameras,
            .observed = observed,
            .past = past,
            .now = from_seconds(100)};
  }

  static Ekf some_filter(test::Random& random, const SE3& nav_T_imu, bool nav) {
    State x{.world_T_imu = nav_T_imu, .v_world = Vector3d(1, 0, 0), .additive = VectorXd::Zero(6)};
    if (nav) {
      x.nav_T_world = test::random_pose(random, 10);
      x.world_T_imu = x.nav_T_world->inverse() * nav_T_imu;
    }
    VectorXd sigmas = VectorXd::Constant(x.core_size(), 0.005);
    sigmas.segment<3>(3).setConstant(0.05);
    const MatrixXd P = sigmas.asDiagonal() * test::random_covariance(random, x.core_size(), 1) *
                       sigmas.asDiagonal();
    return {kStandardChart,
            test::moved(kStandardChart, x, -test::normal_of(random, P)),
            P,
            {.map = Ekf::Map::kPast, .past = {.recalls = true}}};
  }

  // A landmark of the state whose error is mostly that of the pose.
  void observe(const Vector3d& p_imu, const PatchView& view) {
    const int index = static_cast<int>(observed.size());
    const Vector3d arm = filter.state().world_T_imu.R * (p_imu + 0.02 * random.normal_vector(3));
    NewLandmark fresh;
    fresh.id = 100 + index;
    fresh.p_world = filter.state().world_T_imu.p + arm;
    fresh.d_pose << -hat(arm), Matrix3d::Identity();
    fresh.noise = 4e-4 * Matrix3d::Identity();
    filter.add({&fresh, 1});
    const Camera& camera = cameras.front();
    observed.push_back(
        {.id = fresh.id,
         .index = index,
         .pixel = project(camera, camera.cam_T_imu * p_imu)->pixel +
                  std::sqrt(returned_variance(kPixelSigma)) * random.normal_vector(2),
         .view = view});
  }

  test::Random random;
  std::shared_ptr<const LandmarkMap> map =
      std::make_shared<LandmarkMap>(test::corridor_map(3, 200, 40));
  SE3 nav_T_map = test::level_pose(2.2, {30, -11, 4});
  std::vector<Camera> cameras = test::inertial_cameras();
  Ekf filter;
  std::vector<ObservedLandmark> observed;
  std::vector<int> points;  ///< of the map, that are observed; -1: not in the map
  PastLandmarks past;
};

// The matches at the proposed place, of which the true ones are accepted.
struct TrueMatches {
  TrueMatches(const InTheCorridor& x, MapPlacer& placer)
      : candidates(similar_landmarks(x.cameras, x.filter.state(), placer.points(), x.observed)),
        innovations(loop_innovations(x.cameras.front(), x.filter, candidates,
                                     placer.known_points(x.filter, candidates), x.observed)) {
    for (std::size_t i = 0; i < innovations.matches.size(); ++i) {
      const ProposedMatch& match = innovations.matches[i];
      const int point = candidates[static_cast<std::size_t>(match.landmark)].past->number;
      if (x.points[static_cast<std::size_t>(match.observation)] == point) {
        accepted.push_back(static_cast<int>(i));
      }
    }
  }

  std::vector<LoopCandidate> candidates;
  LoopInnovations innovations;
  std::vector<int> accepted;
};

TEST(MapPlacer, ProposesThePlaceFromWhichItsPointsLookSo) {
  for (const std::uint64_t seed : {1, 2}) {  // without and with nav_T_world
    const InTheCorridor x(seed, 12, 10);
    MapPlacer placer(x.map);
    ASSERT_TRUE(placer.searching());
    placer.propose(x.here());
    ASSERT_TRUE(placer.proposed());
    EXPECT_EQ(placer.counts().searches, 1);
    EXPECT_EQ(placer.counts().proposed, 1);
    ASSERT_EQ(placer.points().size(), x.map->points.size());
    for (std::size_t k = 0; k < 12; ++k) {
      const PastLandmark& point = placer.points().at(kFirstMapId + x.points[k]);
      EXPECT_EQ(point.number, x.points[k]);
      const Vector3d truth =
          x.nav_T_map * x.map->points[static_cast<std::size_t>(x.points[k])].p_map;
      EXPECT_LT((point.p_nav - truth).norm(), 0.6);
      EXPECT_LE(point.appearance.distance(x.observed[k].view).value_or(256), 20)
          << "in the axes of nav";
    }
  }
}

TEST(MapPlacer, ProposesNothingForOtherThingsOrForTheSameInAnotherOrder) {
  const InTheCorridor others(1, 0, 30);
  MapPlacer placer(others.map);
  placer.propose(others.here());
  EXPECT_FALSE(placer.proposed());

  InTheCorridor mixed(1, 12);
  std::vector<PatchView> views;
  for (const ObservedLandmark& o : mixed.observed) views.push_back(o.view);
  for (std::size_t k = 0; k < 12; ++k) mixed.observed[k].view = views[(5 * k + 3) % 12];
  placer.propose(mixed.here());
  EXPECT_FALSE(placer.proposed());
  EXPECT_EQ(placer.counts().searches, 2);
  EXPECT_EQ(placer.counts().proposed, 0);
  MapPlacer without;
  EXPECT_FALSE(without.searching());
}

// Four of seven that are observed are too few, with six that left the state lately they are not.
TEST(MapPlacer, LandmarksThatHaveJustLeftHelp) {
  InTheCorridor x(1, 10);
  for (std::size_t k = 0; k < 6; ++k) {
    Appearance appearance;
    appearance.add(x.observed[k].view);
    x.past[static_cast<LandmarkId>(k)] = {.p_nav = x.filter.state().landmarks[k].p_world,
                                          .appearance = std::move(appearance),
                                          .left = x.here().now - std::chrono::seconds(5)};
  }
  for (std::size_t k = 7; k < 10; ++k) {
    x.observed[k - 7] = x.observed[k];
    x.observed[k].view = test::random_view(x.random, {-4, 1, 0});
  }
  x.observed.erase(x.observed.begin() + 3, x.observed.begin() + 6);
  ASSERT_EQ(x.observed.size(), 7u);
  MapPlacer placer(x.map);
  placer.propose(x.here());
  EXPECT_FALSE(placer.proposed());
  for (auto& [id, landmark] : x.past) landmark.left = x.here().now - std::chrono::seconds(3);
  placer.propose(x.here());
  EXPECT_TRUE(placer.proposed());
  x.observed.pop_back();
  MapPlacer other(x.map);
  other.propose(x.here());
  EXPECT_EQ(other.counts().searches, 0) << "six are observed";
}

// A turn about the camera of 0.3 rad and moves of 5 m, beside the errors of the map itself.
TEST(MapPlacer, KnownPointsHaveTheErrorsOfTheMapAndOfThePlace) {
  const InTheCorridor x(2, 12);
  MapPlacer placer(x.map);
  placer.propose(x.here());
  ASSERT_TRUE(placer.proposed());
  TrueMatches found(x, placer);
  const KnownLandmarks known = placer.known_points(x.filter, found.candidates);
  const SE3 place = placer.placed_map().map_T_prior;
  const auto k = std::ssize(found.candidates);
  ASSERT_GT(k, 8);
  MatrixXd by_place(3 * k, 4), R = MatrixXd::Zero(3 * k, 3 * k);
  std::vector<int> numbers;
  for (Eigen::Index i = 0; i < k; ++i) {
    const int number = found.candidates[static_cast<std::size_t>(i)].past->number;
    const Vector3d p_nav = place * x.map->points[static_cast<std::size_t>(number)].p_map;
    const Landmark& landmark = known.landmarks[static_cast<std::size_t>(i)];
    EXPECT_EQ(landmark.id, kFirstMapId + number);
    EXPECT_LT((landmark.p_world - p_nav).norm(), 1e-12);
    const Vector3d arm = p_nav - nav_T_camera(x.cameras, x.filter.state(), 0).p;
    by_place.middleRows<3>(3 * i) << 0.3 * Vector3d(-arm.y(), arm.x(), 0), 5 * Matrix3d::Identity();
    R.block<3, 3>(3 * i, 3 * i) = place.R;
    numbers.push_back(number);
  }
  EXPECT_TRUE(test::agree(known.by_place, by_place, 1e-9));
  const MatrixXd P = R * x.map->covariance.of(numbers) * R.transpose();
  EXPECT_TRUE(test::agree(known.P - by_place * by_place.transpose(), P, 1e-8));
  EXPECT_EQ(known.C.rows(), 3 * k);
  EXPECT_EQ(known.C.cols(), x.filter.covariance().cols());
  EXPECT_TRUE(known.C.isZero(0)) << "the filter knows nothing of the map";
}

TEST(MapPlacer, FindsAPlaceAgainByThreeOfItsPairs) {
  InTheCorridor x(3, 12);
  MapPlacer placer(x.map);
  placer.propose(x.here());
  ASSERT_TRUE(placer.proposed());
  TrueMatches found(x, placer);
  ASSERT_GE(found.accepted.size(), 8u);
  const auto finds_again = [&](std::size_t pairs) {
    const std::vector<int> some(found.accepted.begin(),
                                found.accepted.begin() + static_cast<std::ptrdiff_t>(pairs));
    return placer.finds_again(x.here(), found.innovations, some, found.candidates);
  };
  EXPECT_FALSE(finds_again(2));
  EXPECT_TRUE(finds_again(3));
  EXPECT_TRUE(finds_again(8));
  // The same place, but other pairs are accepted.
  const LoopInnovations before = found.innovations;
  const int first = found.innovations.matches.front().landmark;
  for (std::size_t i = 0; i + 1 < found.innovations.matches.size(); ++i) {
    found.innovations.matches[i].landmark = found.innovations.matches[i + 1].landmark;
  }
  found.innovations.matches.back().landmark = first;
  EXPECT_FALSE(finds_again(8));
  found.innovations = before;
  for (ObservedLandmark& o : x.observed) o.view = test::random_view(x.random, {-4, 1, 0});
  EXPECT_FALSE(finds_again(8)) << "nothing looks like the map any more";
}

TEST(MapPlacer, GivesAPlaceUpAfterTwoFailuresInARow) {
  const InTheCorridor x(1, 12);
  MapPlacer placer(x.map);
  const auto propose = [&] {
    placer.propose(x.here());
    ASSERT_TRUE(placer.proposed());
  };
  propose();
  placer.note_failure();
  placer.compatible()[{1, 2}] = Vector3d::Zero();  // a view from another place may come
  placer.note_failure();
  placer.compatible().clear();
  placer.note_failure();
  EXPECT_TRUE(placer.proposed());
  placer.note_failure();
  EXPECT_FALSE(placer.proposed());
  EXPECT_TRUE(placer.searching());
  EXPECT_TRUE(placer.points().empty());
  EXPECT_EQ(placer.counts().rejected, 1);
  propose();
  placer.note_failure();
  EXPECT_TRUE(placer.proposed()) << "the failures count anew";
  placer.reject();
  EXPECT_FALSE(placer.proposed());
  EXPECT_EQ(placer.counts().searches, 2);
  EXPECT_EQ(placer.counts().proposed, 2);
  EXPECT_EQ(placer.counts().rejected, 2);
}

TEST(MapPlacer, AKnownPlaceIsTheFrameOfTheMapWithoutErrors) {
  const InTheCorridor x(1, 12);
  MapPlacer placer(x.map);
  placer.propose_nav();
  ASSERT_TRUE(placer.proposed());
  EXPECT_EQ(placer.points().at(kFirstMapId + 7).p_nav, x.map->points[7].p_map);
  const PriorMap prior = placer.placed_map();
  EXPECT_EQ(test::distance(prior.map_T_prior, SE3{}), 0);
  EXPECT_TRUE(prior.shared.topRows<6>().isZero(0));
  EXPECT_TRUE(prior.shared.rightCols<4>().isZero(0));
  EXPECT_EQ(prior.landmarks.size(), x.map->points.size());
  EXPECT_EQ(placer.finish(from_seconds(3)), x.map);
  EXPECT_FALSE(placer.searching());
  EXPECT_FALSE(placer.proposed());
  EXPECT_EQ(placer.counts().placed, from_seconds(3));
}

// Residuals of the pixels of some observed points as a function of the errors of the state, of
// these points of the map, and of the place: a turn about `pivot` and a move.
struct PixelsByPlace {
  const InTheCorridor& x;
  std::vector<int> observations;
  SE3 place;
  Vector3d pivot;

  int point(int observation) const { return x.points[static_cast<std::size_t>(observation)]; }

  VectorXd residuals(const VectorXd& e) const {
    const State y = test::moved(kStandardChart, x.filter.state(), e.head(x.filter.state().size()));
    const SE3 nav_T_imu = y.nav_T_world ? *y.nav_T_world * y.world_T_imu : y.world_T_imu;
    const Eigen::Vector4d by_place = e.tail<4>();
    VectorXd r(2 * std::ssize(observations));
    Eigen::Index i = 0;
    for (const int k : observations) {
      const Vector3d p_map = x.map->points[static_cast<std::size_t>(point(k))].p_map +
                             e.segment<3>(x.filter.state().size() + 3 * i);
      const Vector3d p_nav =
          pivot + so3::exp({0, 0, by_place[0]}) * (place * p_map - pivot) + by_place.tail<3>();
      const Camera& camera = x.cameras.front();
      r.segment<2>(2 * i++) =
          x.observed[static_cast<std::size_t>(k)].pixel -
          project(camera, camera.cam_T_imu * (nav_T_imu.inverse() * p_nav))->pixel;
    }
    return r;
  }
};

// Of least squares over all that is uncertain: at the refined place the derivative vanishes, and
// its error against the truth has the covariance of least squares.
TEST(MapPlacer, RefinesThePlaceByLeastSquares) {
  constexpr int kRuns = 25;
  double nees = 0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const InTheCorridor x(seed, 12);
    MapPlacer placer(x.map);
    placer.propose(x.here());
    ASSERT_TRUE(placer.proposed()) << seed;
    TrueMatches found(x, placer);
    ASSERT_GE(found.accepted.size(), 8u) << seed;
    placer.refine(x.here(), kPixelSigma, found.innovations, found.accepted, found.candidates);

    PixelsByPlace pixels{x, {}, placer.placed_map().map_T_prior, x.here().p_nav()};
    std::vector<int> points;
    for (const int i : found.accepted) {
      pixels.observations.push_back(
          found.innovations.matches[static_cast<std::size_t>(i)].observation);
      points.push_back(pixels.point(pixels.observations.back()));
    }
    const Eigen::Index n = x.filter.state().size(), k = 3 * std::ssize(points);
    const VectorXd zero = VectorXd::Zero(n + k + 4);
    const MatrixXd H = -test::numeric_derivative(
        [&](const VectorXd& e) { return pixels.residuals(e); }, zero, 1e-4);
    const MatrixXd P_points = x.map->covariance.of(points);
    const MatrixXd S = H.leftCols(n) * x.filter.covariance() * H.leftCols(n).transpose() +
                       H.middleCols(n, k) * P_points * H.middleCols(n, k).transpose() +
                       3.25 * MatrixXd::Identity(H.rows(), H.rows());
    const MatrixXd J = H.rightCols<4>(), weighted = S.inverse() * J;
    const Eigen::Matrix4d information = J.transpose() * weighted;
    const Eigen::Vector4d further =
        information.inverse() * (weighted.transpose() * pixels.residuals(zero));
    EXPECT_LT(further.dot(information * further), 1e-4) << "in squares of its sigma";

    const SE3 off = x.nav_T_map * pixels.place.inverse();
    Eigen::Vector4d error;
    error << so3::log(off.R).z(), off * pixels.pivot - pixels.pivot;
    nees += error.dot(information * error);
    const Vector3d p_nav = pixels.place * x.map->points[60].p_map;
    EXPECT_LT((placer.points().at(kFirstMapId + 60).p_nav - p_nav).norm(), 1e-9);
  }
  EXPECT_TRUE(test::is_chi2(nees, 4 * kRuns));
}

}  // namespace
}  // namespace chasles
