#include <algorithm>
#include <chrono>

#include <chasles/filter/inertial_testing.hpp>
#include <chasles/loop/loop_closer.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;

const Ekf::Options kRecalling{.map = Ekf::Map::kPast, .past = {.recalls = true, .records = true}};

// A filter of landmarks 100 to 105, of which some have left by the steps of a frame.
struct LeavingLandmarks {
  explicit LeavingLandmarks(Recognise recognise)
      : random(1),
        filter(test::inertial_filter(kStandardChart, random, false, false, kRecalling)),
        stayed(filter),
        records(filter.state().landmarks.size()),
        closer({.recognise = recognise}, test::inertial_cameras()) {}

  void leave(const std::vector<int>& indices) {
    closer.note_leaving(indices, filter, records, at.now);
    remove(records, indices);
    filter.retire(indices);
    closer.bar_others(filter);
  }

  test::Random random;
  Ekf filter, stayed;
  LandmarkRecords records;
  LoopCloser closer;
  FrameMoment at{.frame = 7, .now = from_seconds(1), .by_imu = from_seconds(1.01)};
};

int row_of(const Ekf& filter, LandmarkId id) {
  return std::ranges::find(filter.state().landmarks, id, &Landmark::id)->row;
}

FeatureFrame frame_of(std::initializer_list<LandmarkId> ids) {
  FeatureFrame frame;
  for (const LandmarkId id : ids) frame.pixels.push_back({.landmark = id});
  return frame;
}

std::optional<LoopReturn> search(LeavingLandmarks& x, const FeatureFrame& frame) {
  std::vector<const PixelObservation*> observations;
  for (const PixelObservation& o : x.closer.renamed(frame)) observations.push_back(&o);
  return x.closer.search(frame, observations, x.filter, x.at);
}

// Their covariance with everything else is that of landmarks that have never left.
TEST(LoopCloser, LandmarksReturnByTheirIdsAsIfTheyHadStayed) {
  LeavingLandmarks x(Recognise::kIds);
  x.leave({0, 2});
  EXPECT_TRUE(x.closer.awaits(100));
  EXPECT_TRUE(x.closer.awaits(102));
  EXPECT_FALSE(x.closer.awaits(101));
  EXPECT_FALSE(search(x, frame_of({101, 9})));

  test::Random same(2), again(2);
  test::walk_on(x.filter, same);
  test::walk_on(x.stayed, again);
  auto found = search(x, frame_of({102, 9, 100}));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->by_appearance());
  x.closer.close(*found, x.filter, x.records, x.at);
  ASSERT_EQ(x.filter.state().landmarks.size(), 6u);
  ASSERT_EQ(x.records.size(), 6u);
  EXPECT_EQ(x.records.back().seen, 7);
  EXPECT_FALSE(x.closer.awaits(100));
  EXPECT_EQ((std::vector<LandmarkId>(x.closer.returned().begin(), x.closer.returned().end())),
            (std::vector<LandmarkId>{102, 100}));
  // In this chart and without nav_T_world the errors of a landmark are those of a past one.
  const MatrixXd P = x.filter.covariance(), P_stayed = x.stayed.covariance();
  for (const LandmarkId id : {100, 102}) {
    const int row = row_of(x.filter, id), stayed = row_of(x.stayed, id);
    EXPECT_TRUE(test::agree(P.block(row, 0, 3, 15), P_stayed.block(stayed, 0, 3, 15), 1e-9));
    EXPECT_TRUE(test::agree(P.block(row, row, 3, 3), P_stayed.block(stayed, stayed, 3, 3), 1e-9));
  }
}

TEST(LoopCloser, SearchesForIdsNowAndThen) {
  LeavingLandmarks x(Recognise::kIds);
  x.leave({0, 2});
  auto found = search(x, frame_of({100}));
  ASSERT_TRUE(found);
  x.closer.close(*found, x.filter, x.records, x.at);
  x.at.now += std::chrono::milliseconds(400);
  EXPECT_FALSE(search(x, frame_of({102})));
  x.at.now += std::chrono::milliseconds(100);
  EXPECT_TRUE(search(x, frame_of({102})));
}

TEST(LoopCloser, ARejectedLandmarkDoesNotReturn) {
  LeavingLandmarks x(Recognise::kIds);
  x.records[0].rejected = 5;
  x.leave({0, 2});
  EXPECT_FALSE(x.closer.awaits(100));
  EXPECT_TRUE(x.closer.awaits(102));
  ASSERT_EQ(x.closer.rejected().size(), 1u);
  EXPECT_EQ(x.closer.rejected().front(), 100);
}

TEST(LoopCloser, ACopyGoesOnWithoutThem) {
  LeavingLandmarks x(Recognise::kIds);
  x.leave({0, 2});
  const auto found = search(x, frame_of({100}));
  ASSERT_TRUE(found);
  x.closer.leave_out(*found, x.filter);
  EXPECT_EQ(x.filter.state().landmarks.size(), 4u);
  x.at.now += std::chrono::seconds(1);
  EXPECT_FALSE(search(x, frame_of({100})));
  EXPECT_TRUE(search(x, frame_of({102})));
}

TEST(LoopCloser, KeepsNothingWhereNothingIsRecognised) {
  LeavingLandmarks x(Recognise::kNone);
  x.leave({0, 2});
  EXPECT_FALSE(x.closer.awaits(100));
  EXPECT_FALSE(search(x, frame_of({100})));
}

TEST(LoopCloser, ListsUndoneClosuresInTheOrderOfTime) {
  LeavingLandmarks x(Recognise::kAppearance);
  const std::vector<Closure> first{{.time = from_seconds(5)}}, second{{.time = from_seconds(3)}};
  x.closer.note_undone(first);
  x.closer.note_undone(second);
  ASSERT_EQ(x.closer.closures().size(), 2u);
  EXPECT_EQ(x.closer.closures().front().time, from_seconds(3));
  EXPECT_TRUE(x.closer.closures().front().undone);
}

}  // namespace
}  // namespace chasles
