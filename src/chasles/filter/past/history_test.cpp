#include <chasles/base/error.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/filter/run_drive_testing.hpp>
#include <chasles/filter/testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using test::DrivenFilter;
using test::DriveOptions;
using test::Motion;

constexpr double kHistoryTolerance = 1e-8;
constexpr double kGate = 11.34;  // chi-square of 3, 99 %

using HistoryTest = test::OverCharts;
INSTANTIATE_TEST_SUITE_P(Charts, HistoryTest, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

// A filter with a history, and one with every landmark in its covariance.
struct Both {
  DrivenFilter compressed, dense;

  Both(const ErrorChart& chart, const test::Drive& drive, const DriveOptions& options,
       const MatrixXd& covariance)
      : compressed(chart, drive, options, covariance, Ekf::Map::kHistory),
        dense(chart, drive, options, covariance, Ekf::Map::kDense) {}

  void run() {
    compressed.run();
    dense.run();
  }

  void retire_all() {
    for (DrivenFilter* filter : {&compressed, &dense}) {
      std::vector<int> all(filter->ekf().state().landmarks.size());
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
      filter->ekf().retire(all);
    }
  }
};

void expect_same_path(const std::vector<PastPose>& path, const std::vector<PastPose>& expected) {
  ASSERT_EQ(path.size(), expected.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "pose " << i << " of " << path.size());
    EXPECT_EQ(path[i].time, expected[i].time);
    EXPECT_LT(test::distance(path[i].map_T_imu, expected[i].map_T_imu), kHistoryTolerance);
    // An exact first pose has none.
    EXPECT_TRUE(test::agree(path[i].covariance, expected[i].covariance, kHistoryTolerance, 1e-15));
  }
}

// All results of the two filters, each in units of its standard deviation.
void expect_same_map(const Both& filters) {
  const Ekf& a = filters.compressed.ekf();
  const Ekf& b = filters.dense.ekf();
  const std::vector<MapLandmark> map = a.map();
  const std::vector<MapLandmark> expected = b.map();
  const MatrixXd P = test::whole_covariance(a);
  const MatrixXd P_expected = test::whole_covariance(b);
  ASSERT_EQ(map.size(), expected.size());
  ASSERT_EQ(a.map_size(), static_cast<int>(map.size()));
  ASSERT_EQ(P.rows(), P_expected.rows());
  EXPECT_LT(test::covariance_difference(P, P_expected), kHistoryTolerance);
  for (std::size_t i = 0; i < map.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "landmark " << i << " of " << map.size());
    EXPECT_EQ(map[i].id, expected[i].id);
    EXPECT_EQ(map[i].observations, expected[i].observations);
    EXPECT_TRUE(test::agree(map[i].p_world, expected[i].p_world, kHistoryTolerance, 0));
    EXPECT_TRUE(test::agree(map[i].covariance, expected[i].covariance, kHistoryTolerance, 0));
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(i);
    EXPECT_TRUE(test::agree(P.block(row, row, 3, 3), expected[i].covariance, kHistoryTolerance, 0));
  }
  expect_same_path(a.past_estimates().poses, b.past_estimates().poses);
  EXPECT_LT(test::distance(a.state(), b.state()), kHistoryTolerance);
  EXPECT_TRUE(test::agree(a.core_covariance(), b.core_covariance(), kHistoryTolerance, 1e-300));
}

TEST_P(HistoryTest, ShowsTheMapThatTheDenseFilterCarriesAlong) {
  const test::Drive drive = test::simulate_drive(
      {.frames = 150, .initial_points = 10, .points_a_frame = 2, .outlier_share = 0.03, .seed = 5});
  const DriveOptions options{.motion = Motion::kVelocityState, .gate = kGate};
  Both filters(chart(), drive, options, test::initial_covariance(options.motion, 0.01));
  filters.run();
  ASSERT_GE(filters.dense.ekf().map_size(), 250);
  ASSERT_LT(filters.dense.ekf().state().landmarks.size(), 60u);
  ASSERT_GE(filters.dense.rejected(), 20);
  expect_same_map(filters);
  EXPECT_EQ(filters.compressed.rejected(), filters.dense.rejected());
}

// The bound gives up what later measurements say about the oldest landmarks, and nothing else.
TEST_P(HistoryTest, ABoundOnItsMemoryMakesOldLandmarksFinal) {
  const test::Drive drive =
      test::simulate_drive({.frames = 150, .initial_points = 10, .points_a_frame = 2, .seed = 12});
  const MatrixXd P = test::initial_covariance(Motion::kVelocityState, 0.01);
  DrivenFilter whole(chart(), drive, {.gate = kGate}, P, Ekf::Map::kHistory);
  whole.run();
  const std::size_t bound = whole.ekf().map_bytes() / 4;
  DrivenFilter bounded(chart(), drive, {.gate = kGate, .map_bytes = bound}, P, Ekf::Map::kHistory);
  std::size_t most = 0;
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    bounded.step();
    most = std::max(most, bounded.ekf().map_bytes());
  }
  EXPECT_LT(most, bound + bound / 5) << "at most by the steps of one frame";
  EXPECT_GT(most, bound / 2);
  EXPECT_EQ(test::distance(bounded.ekf().state(), whole.ekf().state()), 0);
  EXPECT_EQ(bounded.ekf().map_size(), whole.ekf().map_size());
  EXPECT_THROW(test::whole_covariance(bounded.ekf()), UsageError);
  const auto map = bounded.ekf().map(), expected = whole.ekf().map();
  ASSERT_EQ(map.size(), expected.size());
  std::size_t final = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "landmark " << i << " of " << map.size());
    ASSERT_EQ(map[i].id, expected[i].id);
    EXPECT_EQ(map[i].observations, expected[i].observations);
    const double sigma = std::sqrt(map[i].covariance.trace());
    EXPECT_GT(sigma, (1 - 1e-6) * std::sqrt(expected[i].covariance.trace()));
    EXPECT_LT((map[i].p_world - expected[i].p_world).norm(), 4 * sigma);
    const bool same = test::agree(map[i].p_world, expected[i].p_world, kHistoryTolerance, 0) &&
                      test::agree(map[i].covariance, expected[i].covariance, kHistoryTolerance, 0);
    if (!same) final = i + 1;
  }
  EXPECT_GT(final, map.size() / 4);
  EXPECT_LT(final, map.size() - map.size() / 8) << "an eighth of the steps is kept at least";
}

TEST_P(HistoryTest, ShowsTheMapOfEveryMotion) {
  const test::Drive drive =
      test::simulate_drive({.frames = 50, .initial_points = 6, .points_a_frame = 1, .seed = 6});
  for (const Motion motion : {Motion::kVelocityInput, Motion::kInertial}) {
    SCOPED_TRACE(test::motion_test_name(motion));
    const DriveOptions options{.motion = motion, .gate = kGate};
    Both filters(chart(), drive, options, test::initial_covariance(motion, 0.05));
    filters.run();
    expect_same_map(filters);
  }
}

TEST_P(HistoryTest, ShowsTheMapAtAnyTimeWithoutChangingWhatFollows) {
  const test::Drive drive =
      test::simulate_drive({.frames = 24, .initial_points = 5, .points_a_frame = 1, .seed = 7});
  Both filters(chart(), drive, {}, test::initial_covariance(Motion::kVelocityState, 0.05));
  for (std::size_t i = 0; i < drive.frames.size(); ++i) {
    filters.compressed.step();
    filters.dense.step();
    if (i % 4 == 0) expect_same_map(filters);
  }
}

TEST_P(HistoryTest, ShowsTheMapFromAPoseThatWasKnownExactly) {
  const test::Drive drive =
      test::simulate_drive({.frames = 30, .initial_points = 5, .points_a_frame = 1, .seed = 8});
  Both filters(chart(), drive, {.gate = kGate},
               test::initial_covariance(Motion::kVelocityState, 0));
  filters.run();
  expect_same_map(filters);
}

TEST_P(HistoryTest, ShowsTheMapWhereNothingButTheLandmarksIsUncertain) {
  const test::Drive drive = test::simulate_drive(
      {.frames = 30, .initial_points = 5, .points_a_frame = 1, .velocity_noise = 0, .seed = 9});
  const DriveOptions options{.motion = Motion::kVelocityInput, .process_noise = 0};
  Both filters(chart(), drive, options, MatrixXd::Zero(10, 10));
  filters.run();
  expect_same_map(filters);
  EXPECT_TRUE(filters.compressed.ekf().core_covariance().isZero(0));
  // Given the poses, landmarks are independent.
  const MatrixXd P = test::whole_covariance(filters.compressed.ekf());
  EXPECT_TRUE((P.block<3, 3>(3, 0).isZero(0)));
}

TEST_P(HistoryTest, ShowsTheMapWithoutProcessNoise) {
  const test::Drive drive = test::simulate_drive(
      {.frames = 30, .initial_points = 5, .points_a_frame = 1, .velocity_noise = 0, .seed = 10});
  const DriveOptions options{.motion = Motion::kVelocityInput, .process_noise = 0};
  Both filters(chart(), drive, options, test::initial_covariance(options.motion, 0.05));
  filters.run();
  expect_same_map(filters);
}

TEST_P(HistoryTest, HasLandmarksThatWereSeenOnce) {
  test::Drive drive =
      test::simulate_drive({.frames = 12, .initial_points = 6, .points_a_frame = 1, .seed = 11});
  // New ids in every third frame: its landmarks are never observed again.
  for (std::size_t i = 0; i < drive.frames.size(); i += 3) {
    for (StereoObservation& seen : drive.frames[i].observations) {
      seen.landmark += 1000 * static_cast<LandmarkId>(i + 1);
    }
  }
  Both filters(chart(), drive, {.patience = 0},
               test::initial_covariance(Motion::kVelocityState, 0.05));
  filters.run();
  filters.retire_all();
  expect_same_map(filters);
  const auto map = filters.compressed.ekf().map();
  EXPECT_GE(std::count_if(map.begin(), map.end(),
                          [](const MapLandmark& landmark) { return landmark.observations == 1; }),
            10);
}

TEST_P(HistoryTest, ShowsTheMapWhenAllLandmarksAreRetiredAtOnce) {
  const test::Drive drive =
      test::simulate_drive({.frames = 10, .initial_points = 12, .points_a_frame = 1, .seed = 12});
  Both filters(chart(), drive, {.patience = 100},
               test::initial_covariance(Motion::kVelocityState, 0.05));
  filters.run();
  filters.retire_all();
  EXPECT_TRUE(filters.compressed.ekf().state().landmarks.empty());
  expect_same_map(filters);
}

TEST_P(HistoryTest, HasLandmarksThatWereRetiredBeforeAnyUpdate) {
  const test::Drive drive =
      test::simulate_drive({.frames = 8, .initial_points = 8, .points_a_frame = 1, .seed = 13});
  Both filters(chart(), drive, {}, test::initial_covariance(Motion::kVelocityState, 0.05));
  filters.compressed.step();
  filters.dense.step();
  filters.retire_all();
  expect_same_map(filters);
  filters.run();
  expect_same_map(filters);
}

TEST_P(HistoryTest, OfAFilterThatSawNothingIsTheCoreAlone) {
  const MatrixXd covariance = test::initial_covariance(Motion::kVelocityState, 0.05);
  test::Drive drive = test::simulate_drive({.frames = 5});
  for (test::DriveFrame& frame : drive.frames) frame.observations.clear();
  Both filters(chart(), drive, {}, covariance);
  expect_same_map(filters);
  EXPECT_TRUE(filters.compressed.ekf().map().empty());
  EXPECT_EQ(test::whole_covariance(filters.compressed.ekf()), covariance);
  filters.run();
  expect_same_map(filters);
}

TEST_P(HistoryTest, LaterMeasurementsBetterARetiredLandmark) {
  const test::Drive drive =
      test::simulate_drive({.frames = 20, .initial_points = 8, .points_a_frame = 1, .seed = 14});
  // The latest landmark leaves at once. The remaining ones increasingly constrain the pose from
  // which it was observed.
  DrivenFilter filter(chart(), drive, {.patience = 100},
                      test::initial_covariance(Motion::kVelocityState, 0.01), Ekf::Map::kHistory);
  for (int i = 0; i < 6; ++i) filter.step();
  const int youngest[] = {static_cast<int>(filter.ekf().state().landmarks.size()) - 1};
  filter.ekf().retire(youngest);
  const MapLandmark before = filter.ekf().map()[0];
  filter.run();
  const MapLandmark after = filter.ekf().map()[0];
  EXPECT_EQ(before.id, after.id);
  EXPECT_LT(after.covariance.trace(), 0.9999 * before.covariance.trace());
  EXPECT_GT((after.p_world - before.p_world).norm(), 1e-5);
}

}  // namespace
}  // namespace chasles
