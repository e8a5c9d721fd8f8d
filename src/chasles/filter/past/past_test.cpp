#include <array>
#include <numeric>

#include <chasles/base/error.hpp>
#include <chasles/filter/wanderer_testing.hpp>

// Past states against a filter that keeps every one of them in its covariance: landmarks and poses
// that leave, landmarks that return, clones, calibration, composition and changes of scale.

namespace chasles {
namespace {

using Eigen::MatrixXd;
using test::Case;
using test::Wanderer;

constexpr double kPastTolerance = 3e-8;

void expect_same_estimates(const Ekf& a, const Ekf& b) {
  EXPECT_LT(test::distance(a.state(), b.state()), kPastTolerance);
  const MatrixXd P = a.covariance(), expected = b.covariance();
  ASSERT_EQ(P.rows(), expected.rows());
  EXPECT_LT(test::covariance_difference(P, expected), kPastTolerance);
  const Past::Estimates past = a.past().estimates(), dense = b.past().estimates();
  ASSERT_EQ(past.landmarks.size(), dense.landmarks.size());
  ASSERT_EQ(past.poses.size(), dense.poses.size());
  EXPECT_EQ(a.past().map_size(), static_cast<int>(past.landmarks.size()));
  for (std::size_t i = 0; i < past.landmarks.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "landmark " << i);
    const MapLandmark &one = past.landmarks[i], &other = dense.landmarks[i];
    ASSERT_EQ(one.id, other.id);
    EXPECT_EQ(one.observations, other.observations);
    EXPECT_TRUE(test::agree(one.p_world, other.p_world, kPastTolerance, 0));
    EXPECT_TRUE(test::agree(one.covariance, other.covariance, kPastTolerance, 0));
  }
  for (std::size_t i = 0; i < past.poses.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "pose " << i);
    EXPECT_EQ(past.poses[i].time, dense.poses[i].time);
    EXPECT_LT(test::distance(past.poses[i].map_T_imu, dense.poses[i].map_T_imu), kPastTolerance);
    EXPECT_TRUE(
        test::agree(past.poses[i].covariance, dense.poses[i].covariance, kPastTolerance, 0));
  }
}

TEST(Past, RecallShowsWhatRevivalWouldBring) {
  const Case c{.chart = "left-se3", .calibrating = true, .revives = false};
  Wanderer filter(c, Ekf::Map::kPast), dense(c, Ekf::Map::kDense);
  for (int i = 0; i < 40; ++i) {
    filter.step();
    dense.step();
  }
  const std::vector<int> numbers{filter.inactive()[1], filter.inactive()[7],
                                 filter.inactive().back()};
  const Carried recalled = filter.ekf().past().recall(numbers),
                expected = dense.ekf().past().recall(numbers);
  EXPECT_TRUE(test::agree(recalled.P, expected.P, kPastTolerance, 0));
  EXPECT_TRUE(test::agree(recalled.C, expected.C, kPastTolerance, 0));
  EXPECT_TRUE(test::agree(recalled.correction, expected.correction, kPastTolerance, 1e-12));
  Ekf revived = filter.ekf();
  const Eigen::Index before = revived.covariance().rows();
  revived.revive(numbers);
  const MatrixXd P = revived.covariance();
  ASSERT_EQ(P.rows(), before + 9);
  EXPECT_TRUE(test::agree(P.bottomRightCorner(9, 9), recalled.P, 1e-12, 0));
  EXPECT_TRUE(test::agree(P.bottomLeftCorner(9, before), recalled.C, 1e-12, 0));
  EXPECT_EQ(P.topLeftCorner(before, before), filter.ekf().covariance());
}

// In a chart with additive landmarks, a landmark that leaves and returns is one that stayed.
TEST(Past, ALandmarkThatReturnsIsOneThatNeverLeft) {
  for (const char* chart : {"standard", "left-se3", "right-se3"}) {
    SCOPED_TRACE(chart);
    test::Random random(5), same(5);
    const Ekf::Options options{.map = Ekf::Map::kPast, .past = {.recalls = true}};
    Ekf leaves = test::inertial_filter(error_chart(chart), random, false, true, options);
    Ekf stays = test::inertial_filter(error_chart(chart), same, false, true, options);
    for (Ekf* filter : {&leaves, &stays}) filter->make_cartesian(3);
    const int away[] = {2, 3};
    leaves.retire(away);
    for (int i = 0; i < 20; ++i) {
      for (const auto& [filter, source] : {std::pair(&leaves, &random), std::pair(&stays, &same)}) {
        test::walk_on(*filter, *source);
        filter->clone_pose(50 + i, from_seconds(10 + i));
        std::vector<Measurement> measurements;
        for (const LandmarkId id : {100, 101, 104, 105}) {
          const auto& landmarks = filter->state().landmarks;
          const auto at = std::ranges::find(landmarks, id, &Landmark::id);
          const auto index = static_cast<int>(at - landmarks.begin());
          auto z = measure_pixel(test::inertial_cameras()[0], 1, filter->state(), index, {0, 0});
          const Eigen::Vector2d noise = 0.3 * source->normal_vector(2);
          if (!z) continue;
          z->residual = noise;
          measurements.push_back(*z);
        }
        filter->update(measurements);
        const int old[] = {49 + i};
        if (i > 0) filter->remove_clones(old);
      }
    }
    const int back[] = {0, 1};
    leaves.revive(back);
    const State &a = leaves.state(), &b = stays.state();
    ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
    std::vector<int> rows_a(static_cast<std::size_t>(a.core_size()));
    std::iota(rows_a.begin(), rows_a.end(), 0);
    std::vector<int> rows_b = rows_a;
    for (const Landmark& one : b.landmarks) {
      const auto other = std::ranges::find(a.landmarks, one.id, &Landmark::id);
      ASSERT_NE(other, a.landmarks.end());
      EXPECT_LT((a.p_world(*other) - b.p_world(one)).norm(), kPastTolerance);
      for (int k = 0; k < 3; ++k) {
        rows_a.push_back(other->row + k);
        rows_b.push_back(one.row + k);
      }
    }
    const MatrixXd P = leaves.covariance()(rows_a, rows_a), Q = stays.covariance()(rows_b, rows_b);
    EXPECT_LT(test::covariance_difference(P, Q), kPastTolerance);
  }
}

TEST(Past, ABoundOnItsMemoryMakesOldStatesFinal) {
  constexpr int kSteps = 300, kCondensedAfter = 1;
  const Case c{.chart = "right-sen3", .revives = false, .recalls = false};
  Wanderer whole(c, Ekf::Map::kPast, 0, kCondensedAfter);
  for (int i = 0; i < kSteps; ++i) whole.step();
  const std::size_t bound = whole.ekf().past().bytes() / 2;
  Wanderer bounded(c, Ekf::Map::kPast, bound, kCondensedAfter);
  std::size_t most = 0;
  for (int i = 0; i < kSteps; ++i) {
    bounded.step();
    most = std::max(most, bounded.ekf().past().bytes());
  }
  EXPECT_LT(most, bound + bound / 5);
  EXPECT_EQ(test::distance(bounded.ekf().state(), whole.ekf().state()), 0);
  const Past::Estimates some = bounded.ekf().past().estimates(),
                        all = whole.ekf().past().estimates();
  ASSERT_EQ(some.landmarks.size(), all.landmarks.size());
  ASSERT_EQ(some.poses.size(), all.poses.size());
  std::size_t final = 0;
  for (std::size_t i = 0; i < some.poses.size(); ++i) {
    EXPECT_EQ(some.poses[i].time, all.poses[i].time);
    EXPECT_GT(some.poses[i].covariance.trace(), (1 - 1e-9) * all.poses[i].covariance.trace());
    final += test::agree(some.poses[i].covariance, all.poses[i].covariance, 1e-9, 0) ? 0u : 1u;
  }
  EXPECT_GT(final, some.poses.size() / 4);
  EXPECT_LT(final, some.poses.size());
}

// States are condensed as soon as two more segments have ended.
TEST(Past, CondensedStatesHaveTheEstimatesOfAll) {
  constexpr double kTolerance = 1e-7;  // of the sigmas
  for (const Case& c : test::wanderer_cases()) {
    if (c.recalls) continue;
    SCOPED_TRACE(test::name_of(c));
    Wanderer filter(c, Ekf::Map::kPast, 0, 1), dense(c, Ekf::Map::kDense);
    for (int i = 0; i < 100; ++i) {
      filter.step();
      dense.step();
    }
    const Past::Estimates some = filter.ekf().past().estimates(),
                          all = dense.ekf().past().estimates();
    ASSERT_EQ(some.poses.size(), all.poses.size());
    for (std::size_t i = 0; i < all.poses.size(); ++i) {
      const PastPose &one = some.poses[i], &other = all.poses[i];
      EXPECT_EQ(one.time, other.time);
      EXPECT_LT(test::distance(one.map_T_imu, other.map_T_imu), kTolerance);
      EXPECT_LT(test::covariance_difference(one.covariance, other.covariance), kTolerance);
    }
    ASSERT_EQ(some.landmarks.size(), all.landmarks.size());
    for (std::size_t i = 0; i < all.landmarks.size(); ++i) {
      const MapLandmark &one = some.landmarks[i], &other = all.landmarks[i];
      ASSERT_EQ(one.id, other.id);
      EXPECT_LT((one.p_world - other.p_world).norm(), kTolerance);
      EXPECT_LT(test::covariance_difference(one.covariance, other.covariance), kTolerance);
    }
  }
}

// Landmarks that can return are not final: poses alone.
TEST(Past, ABoundOnItsMemoryLeavesReturningLandmarksExact) {
  const Case c{.chart = "right-sen3"};
  Wanderer whole(c, Ekf::Map::kPast);
  for (int i = 0; i < 150; ++i) whole.step();
  Wanderer bounded(c, Ekf::Map::kPast, whole.ekf().past().bytes() / 6);
  for (int i = 0; i < 150; ++i) bounded.step();
  EXPECT_EQ(test::distance(bounded.ekf().state(), whole.ekf().state()), 0);
  const Past::Estimates some = bounded.ekf().past().estimates(),
                        all = whole.ekf().past().estimates();
  ASSERT_EQ(some.landmarks.size(), all.landmarks.size());
  for (std::size_t i = 0; i < some.landmarks.size(); ++i) {
    ASSERT_EQ(some.landmarks[i].id, all.landmarks[i].id);
    EXPECT_TRUE(test::agree(some.landmarks[i].p_world, all.landmarks[i].p_world, 1e-9, 0));
    EXPECT_TRUE(test::agree(some.landmarks[i].covariance, all.landmarks[i].covariance, 1e-8, 0));
  }
  ASSERT_EQ(some.poses.size(), all.poses.size());
  std::size_t final = 0;
  for (std::size_t i = 0; i < some.poses.size(); ++i) {
    EXPECT_EQ(some.poses[i].time, all.poses[i].time);
    EXPECT_GT(some.poses[i].covariance.trace(), (1 - 1e-8) * all.poses[i].covariance.trace());
    final += test::agree(some.poses[i].covariance, all.poses[i].covariance, 1e-8, 0) ? 0u : 1u;
  }
  EXPECT_GT(final, some.poses.size() / 4);
  EXPECT_LT(final, some.poses.size());
}

TEST(Past, APriorMapThatDoesNotFitIsRejected) {
  test::Random random(8);
  Ekf filter = test::inertial_filter(kStandardChart, random, false, false,
                                     {.map = Ekf::Map::kPast, .past = {.recalls = true}});
  const PriorMap right{.map_T_prior = {},
                       .landmarks = {{.id = 7}},
                       .shared = MatrixXd::Zero(9, 2),
                       .own = {Eigen::Matrix3d::Identity()}};
  PriorMap wrong = right;
  wrong.own.clear();
  EXPECT_THROW(filter.add_past(wrong), UsageError);
  wrong = right;
  wrong.shared.resize(10, 2);
  EXPECT_THROW(filter.add_past(wrong), UsageError);
  EXPECT_EQ(filter.past().states(), 0);
  EXPECT_EQ(filter.add_past(right), 0);
  Ekf frozen = test::inertial_filter(kStandardChart, random, false, false);
  EXPECT_THROW(frozen.add_past(right), UsageError);
}

TEST(Past, NeedsAFilterThatKeepsIt) {
  test::Random random(6);
  Ekf filter = test::inertial_filter(kStandardChart, random, false, false);
  const int none[] = {0};
  EXPECT_THROW(filter.remember_pose(Time{}), UsageError);
  EXPECT_THROW(filter.revive(none), UsageError);
  EXPECT_TRUE(filter.past().estimates().poses.empty());
  Ekf past = test::inertial_filter(kStandardChart, random, false, false,
                                   {.map = Ekf::Map::kPast, .past = {.recalls = true}});
  const int first[] = {0};
  past.retire(first);
  EXPECT_THROW(past.revive(std::array{7}), UsageError);
  past.revive(first);
  EXPECT_THROW(past.revive(first), UsageError) << "it has returned";
  past.retire(first);
  past.bar_return(std::array{1});
  EXPECT_THROW(past.revive(std::array{1}), UsageError) << "it is marginalised";
  EXPECT_EQ(past.past().estimates().landmarks.size(),
            static_cast<std::size_t>(past.past().map_size()));
}

class PastTest : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Runs, PastTest, ::testing::ValuesIn(test::wanderer_cases()),
                         [](const auto& info) { return test::name_of(info.param); });

TEST_P(PastTest, IsThatOfAFilterThatMarginalisesNothing) {
  Wanderer filter(GetParam(), Ekf::Map::kPast), dense(GetParam(), Ekf::Map::kDense);
  for (int i = 0; i < 60; ++i) {
    filter.step();
    dense.step();
    if (i % 20 == 7) expect_same_estimates(filter.ekf(), dense.ekf());
  }
  expect_same_estimates(filter.ekf(), dense.ekf());
  EXPECT_EQ(filter.revived(), dense.revived());
  if (GetParam().prior) {
    std::vector<int> numbers = filter.frames();
    numbers.insert(numbers.end(), filter.inactive().begin(), filter.inactive().end());
    std::ranges::sort(numbers);
    const std::vector<int> in_state{0, 2};
    const Carried some = filter.ekf().past().recall(numbers, in_state),
                  all = dense.ekf().past().recall(numbers, in_state);
    EXPECT_TRUE(test::agree(some.P, all.P, kPastTolerance, 0));
    EXPECT_TRUE(test::agree(some.C, all.C, kPastTolerance, 0));
    EXPECT_TRUE(test::agree(some.correction, all.correction, kPastTolerance, 1e-12));
  }
  if (GetParam().revives) {
    EXPECT_GE(filter.revived(), 12);
  }
}

}  // namespace
}  // namespace chasles
