#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/base/error.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/trajectory.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run_of_images_testing.hpp>

// Runs that leave maps, and runs in these, on rendered walks.
namespace chasles {
namespace {

using Eigen::Matrix3d;
using test::RunOfImages;

// Of a pose [rotation; position], standard error.
Vector6d error_of(const SE3& pose, const SE3& truth) {
  Vector6d error;
  error << so3::log(truth.R * pose.R.transpose()), truth.p - pose.p;
  return error;
}

double nees_per_dof(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / 6;
}

// What a run leaves, and what one in its map estimates.
class RunInAMap : public RunOfImages {
 protected:
  struct Result {
    std::vector<Estimate> estimates;
    Time started{};  // the frame that completed the first estimate
    PlaceCounts places;
    LandmarkMap map;
  };
  static Result run_in(const Recording& recording, std::shared_ptr<const LandmarkMap> map,
                       const InitialiserSettings& start = {},
                       PriorMapUse use = PriorMapUse::kEstimated) {
    class Estimates : public RunObserver {
     public:
      void on_frame(const FeatureFrame& frame) override {
        if (list.empty()) latest = frame.time;
      }
      void on_estimate(const Estimate& e, const EstimateTiming&) override { list.push_back(e); }
      Time latest{};
      std::vector<Estimate> list;
    };
    InertialRunSettings settings;
    settings.filter.recognise = Recognise::kAppearance;
    settings.filter.prior_map = use;
    settings.start = start;
    const auto estimator = make_estimator(decided(settings, recording), inertial_sensors(recording),
                                          std::nullopt, std::move(map));
    Estimates observer;
    const RunReport report = run(recording, *estimator, {}, {.threads = 1}, observer);
    return {.estimates = observer.list,
            .started = observer.latest,
            .places = report.estimator.places,
            .map = estimator->landmark_map().value_or(LandmarkMap{})};
  }
  // Once round the block, and a walk with other steps in the same place.
  static const Recording& round() {
    static const Recording recording = walked([](InertialSettings& s) { s.sections = 4; });
    return recording;
  }
  static const Recording& again() {
    static const Recording recording = walked([](InertialSettings& s) { s.step_rate = 1.5; });
    return recording;
  }
  template <typename Change>
  static Recording walked(const Change& change) {
    InertialScene scene = walk_scene();
    change(scene.settings);
    return render_inertial(scene);
  }
  // Of the poses in the map: their number, and mean NEES. None errs by more than 15 cm, or by more
  // than its sigma where that is larger, as in the first frames after a place was found.
  static std::pair<int, double> assessed(const Result& result, const Recording& recording,
                                         const SE3& truth_T_map) {
    double nees = 0;
    int placed = 0;
    for (const Estimate& e : result.estimates) {
      if (!e.in_map) continue;
      const SE3 truth = truth_T_map.inverse() * pose_at(recording.truth, e.time).value();
      const Vector6d error = error_of(e.in_map->map_T_imu, truth);
      const double sigma = std::sqrt(e.in_map->covariance.diagonal().tail<3>().sum());
      EXPECT_LT(error.tail<3>().norm(), std::max(0.15, sigma)) << placed;
      nees += nees_per_dof(error, e.in_map->covariance);
      ++placed;
    }
    return {placed, nees / std::max(placed, 1)};
  }
  static const Result& first() {
    static const Result result = run_in(round(), nullptr);
    return result;
  }
  // The world of a run in that of the truth, by its first pose.
  static SE3 truth_T_world(const Result& result, const Recording& recording) {
    const Estimate& e = result.estimates.front();
    return pose_at(recording.truth, e.time).value() * e.world_T_imu.inverse();
  }
};

TEST_F(RunInAMap, FindsItsPlaceThere) {
  const Result& before = first();
  ASSERT_GT(before.map.points.size(), 150u);
  ASSERT_EQ(before.map.sessions.size(), 1u);
  EXPECT_EQ(before.map.sessions[0].begin, before.estimates.front().time);
  EXPECT_EQ(before.map.covariance.points(), static_cast<int>(before.map.points.size()));
  const auto map = std::make_shared<const LandmarkMap>(before.map);
  const Result result = run_in(again(), map);
  ASSERT_TRUE(result.places.placed);
  EXPECT_FALSE(result.estimates.front().in_map);
  ASSERT_TRUE(result.estimates.back().in_map);
  for (const Estimate& e : result.estimates) {
    if (!e.in_map) continue;
    EXPECT_GE(e.time, *result.places.placed);
    // The frame of the map is where the pose says.
    const SE3 in_world = e.in_map->world_T_map * e.in_map->map_T_imu;
    EXPECT_LT((in_world.p - e.world_T_imu.p).norm(), 1e-9);
  }
  const auto [placed, nees] = assessed(result, again(), truth_T_world(before, round()));
  EXPECT_GT(placed, static_cast<int>(result.estimates.size()) / 2);
  EXPECT_LT(nees, 3);

  // What it leaves has the landmarks of both, in the frame of the first.
  ASSERT_EQ(result.map.sessions.size(), 2u);
  EXPECT_GT(result.map.points.size(), before.map.points.size());
  const auto of_first = std::ranges::count(result.map.points, 0, &MapPoint::session);
  EXPECT_EQ(of_first, static_cast<long>(before.map.points.size()));
  // They moved by what their sigmas allow, and are known better: but for those that were found
  // again, which are not quite the same points.
  int better = 0;
  for (std::size_t i = 0; i < result.map.points.size(); ++i) {
    const MapPoint& point = result.map.points[i];
    if (point.session != 0) continue;
    const auto distance = [&](const MapPoint& old) { return (point.p_map - old.p_map).norm(); };
    const auto old = std::ranges::min_element(before.map.points, {}, distance);
    const double variance =
        before.map.covariance.of(static_cast<int>(old - before.map.points.begin())).trace();
    EXPECT_LT(distance(*old), 4 * std::sqrt(variance));
    better += result.map.covariance.of(static_cast<int>(i)).trace() < variance ? 1 : 0;
  }
  EXPECT_GT(better, 0.9 * static_cast<double>(before.map.points.size()));
  // The same bytes again.
  const Result repeated = run_in(again(), map);
  EXPECT_EQ(repeated.estimates.back().in_map->map_T_imu.p,
            result.estimates.back().in_map->map_T_imu.p);
  EXPECT_EQ(repeated.map.covariance.shared(), result.map.covariance.shared());
}

// Its landmarks, and what it says of them, are the same afterwards; the pose in it has the errors
// that it states.
TEST_F(RunInAMap, LeavesAConsideredMapAsItIs) {
  const auto map = std::make_shared<const LandmarkMap>(first().map);
  const Result result = run_in(again(), map, {}, PriorMapUse::kConsidered);
  ASSERT_TRUE(result.places.placed);
  const auto [placed, nees] = assessed(result, again(), truth_T_world(first(), round()));
  EXPECT_GT(placed, static_cast<int>(result.estimates.size()) / 2);
  EXPECT_LT(nees, 3);
  int same = 0;
  for (std::size_t i = 0; i < result.map.points.size(); ++i) {
    const MapPoint& point = result.map.points[i];
    if (point.session != 0) continue;
    const auto old = std::ranges::find(map->points, point.p_map, &MapPoint::p_map);
    ASSERT_NE(old, map->points.end()) << i;
    const Matrix3d before = map->covariance.of(static_cast<int>(old - map->points.begin()));
    const Matrix3d after = result.map.covariance.of(static_cast<int>(i));
    EXPECT_LT((after - before).norm(), 1e-6 * before.norm()) << i;
    ++same;
  }
  EXPECT_GT(same, static_cast<int>(map->points.size()) - 20);
  EXPECT_GT(result.map.points.size(), map->points.size());
}

// The filter takes the frames of the initialisation again, and looks at some of their images.
TEST_F(RunInAMap, StartedInMotionItFindsItsPlaceInTheFramesBeforeTheStart) {
  const Recording moving = walked([](InertialSettings& settings) {
    settings.step_rate = 1.5;
    settings.rest_duration = 0;
  });
  const Result result = run_in(moving, std::make_shared<const LandmarkMap>(first().map));
  ASSERT_TRUE(result.places.placed);
  EXPECT_LT(result.estimates.front().time, result.started);
  EXPECT_LE(*result.places.placed, result.started);
  EXPECT_GT(assessed(result, moving, truth_T_world(first(), round())).first, 0);
}

// No search: the frame of the run is that of the map, from the first estimate on.
TEST_F(RunInAMap, BeginsWhereStated) {
  const auto map = std::make_shared<const LandmarkMap>(first().map);
  const SE3 truth_T_map = truth_T_world(first(), round());
  const Result free = run_in(again(), nullptr);
  const SE3 map_T_imu =
      truth_T_map.inverse() * pose_at(again().truth, free.estimates.front().time).value();
  InitialiserSettings start;
  start.in_map = true;
  start.heading = camera_heading(map_T_imu.R, again().cameras.front()) + 0.05;
  start.heading_sigma = 0.05;
  start.position_x = map_T_imu.p.x() + 0.2;
  start.position_y = map_T_imu.p.y() - 0.2;
  start.position_z = map_T_imu.p.z() + 0.1;
  start.position_sigma = 0.2;
  const Result with_start = run_in(again(), map, start);
  EXPECT_EQ(with_start.places.searches, 0);
  ASSERT_TRUE(with_start.places.placed);
  ASSERT_TRUE(with_start.estimates.front().in_map);
  double nees = 0;
  for (const Estimate& e : with_start.estimates) {
    ASSERT_TRUE(e.in_map);
    EXPECT_LT((e.in_map->map_T_imu.p - e.world_T_imu.p).norm(), 1e-9);
    const SE3 truth = truth_T_map.inverse() * pose_at(again().truth, e.time).value();
    nees += nees_per_dof(error_of(e.world_T_imu, truth), e.pose_covariance());
  }
  EXPECT_LT(nees / static_cast<double>(with_start.estimates.size()), 3);
  const Estimate& last = with_start.estimates.back();
  const SE3 truth = truth_T_map.inverse() * pose_at(again().truth, last.time).value();
  EXPECT_LT((truth.p - last.world_T_imu.p).norm(), 0.1);
  EXPECT_LT(last.covariance.block(3, 3, 3, 3).trace(), 0.1 * 0.1);
  EXPECT_LT(with_start.estimates.front().covariance(3, 3), 0.3 * 0.3);

  EXPECT_THROW(run_in(again(), nullptr, start), UsageError);
  start.heading.reset();
  start.heading_sigma = 0;
  EXPECT_THROW(run_in(again(), map, start), UsageError);
}

// Twice round the block, without samples for two seconds in between: the part after the gap finds
// its place in the map of the part before, whose frame is that of the run.
TEST_F(RunInAMap, AfterALossIsThatOfThePartBefore) {
  InertialScene scene = walk_scene();
  scene.settings.sections = 6;
  Recording interrupted = render_inertial(scene);
  const Time middle = interrupted.truth.front().time + from_seconds(scene.settings.rest_duration) +
                      (interrupted.truth.back().time - interrupted.truth.front().time) * 4 / 6;
  std::erase_if(interrupted.imu, [&](const ImuSample& sample) {
    return sample.time > middle && sample.time < middle + from_seconds(2);
  });
  const Result result = run_in(interrupted, nullptr);
  ASSERT_TRUE(result.places.placed);
  EXPECT_GT(*result.places.placed, middle);
  ASSERT_TRUE(result.estimates.back().in_map);
  for (const Estimate& e : result.estimates) EXPECT_TRUE(!e.in_map || e.time > middle);
  EXPECT_GT(assessed(result, interrupted, truth_T_world(result, interrupted)).first, 0);
  // Without it, the position is that of dead reckoning, and says so.
  const Estimate& last = result.estimates.back();
  EXPECT_GT(last.covariance(3, 3), 100 * last.in_map->covariance(3, 3));
  EXPECT_EQ(result.map.sessions.size(), 2u);
}

TEST_F(RunInAMap, OfAnotherPlaceIsARunWithout) {
  InertialScene scene = walk_scene();
  scene.settings.seed = 2;
  const Result other = run_in(render_inertial(scene), nullptr);
  ASSERT_GT(other.map.points.size(), 25u);
  const Result without = run_in(again(), nullptr);
  const Result result = run_in(again(), std::make_shared<const LandmarkMap>(other.map));
  EXPECT_FALSE(result.places.placed);
  EXPECT_GT(result.places.searches, 10);
  EXPECT_EQ(result.places.proposed, result.places.rejected);
  ASSERT_EQ(result.estimates.size(), without.estimates.size());
  EXPECT_FALSE(result.estimates.back().in_map);
  EXPECT_EQ(result.estimates.back().world_T_imu.p, without.estimates.back().world_T_imu.p);
}

TEST_F(RunInAMap, IsForAFilterThatRecognises) {
  const auto map = std::make_shared<const LandmarkMap>();
  InertialRunSettings settings;
  EXPECT_THROW(make_estimator(settings, inertial_sensors(walk()), std::nullopt, map), UsageError);
  settings.filter.recognise = Recognise::kAppearance;
  settings.estimator = estimator_choice("batch");
  EXPECT_THROW(make_estimator(settings, inertial_sensors(walk()), std::nullopt, map), UsageError);
  // Nothing is recognised, nothing left.
  settings = {};
  const auto estimator = make_estimator(settings, walk());
  RunObserver nobody;
  run(walk(), *estimator, {}, {.threads = 1}, nobody);
  EXPECT_FALSE(estimator->landmark_map());
}

}  // namespace
}  // namespace chasles
