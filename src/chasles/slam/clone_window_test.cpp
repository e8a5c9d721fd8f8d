#include <chasles/slam/clone_window.hpp>
#include <chasles/slam/step_testing.hpp>

namespace chasles {
namespace {

TEST(CloneWindow, EveryNthFrameAndEachIntervalBecomesAClone) {
  test::Random random(1);
  SlamContext x = test::some_context(random);
  x.settings.frames_per_clone = 3;
  x.settings.clone_interval = 1;
  CloneWindow clones;
  const auto augmented = [&](double seconds, bool standstill = false, bool blind = false) {
    ++x.frame;
    FeatureFrame frame{.time = from_seconds(seconds)};
    if (!blind) frame.pixels.push_back({.landmark = 1});
    clones.augment(x, frame, standstill);
    return clones.augmented();
  };
  EXPECT_TRUE(augmented(10));
  const int first = x.frame;
  EXPECT_FALSE(augmented(10.1));
  EXPECT_FALSE(augmented(10.2, false, true)) << "no observation, no count";
  EXPECT_FALSE(augmented(10.3));
  EXPECT_TRUE(augmented(10.4));
  EXPECT_FALSE(augmented(10.5));
  EXPECT_TRUE(augmented(11.5)) << "after the interval";
  EXPECT_FALSE(augmented(12.5, true)) << "during a standstill";
  EXPECT_EQ(clones.oldest(), first);
  EXPECT_EQ(x.state().clones.back().id, x.frame - 1);
}

// Each is counted for itself: with one count, the clones would be those of one camera alone.
TEST(CloneWindow, CamerasThatTakeTurnsHaveTheirOwnClones) {
  test::Random random(1);
  SlamContext x = test::some_context(random);
  x.settings.frames_per_clone = 2;
  x.settings.clone_interval = 10;
  CloneWindow clones;
  std::vector<int> of_clones;
  for (int k = 0; k < 12; ++k) {
    ++x.frame;
    const FeatureFrame frame{.time = from_seconds(10 + 0.05 * k),
                             .pixels = {{.landmark = 1, .camera = k % 2}}};
    clones.augment(x, frame, false);
    if (clones.augmented()) of_clones.push_back(k % 2);
  }
  EXPECT_EQ(of_clones, (std::vector{0, 1, 0, 1, 0, 1}));
}

TEST(CloneWindow, UnusedClonesLeave) {
  test::Random random(2);
  SlamContext x = test::some_context(random);
  x.keep_pose(x.now);
  x.keep_pose(x.now);  // once per frame
  ++x.frame;
  x.keep_pose(x.now);
  ASSERT_EQ(x.state().clones.size(), 5u);
  CloneWindow clones;
  Reused<WaitingTrack> tracks;
  tracks.append().views = {{.clone = 4}};
  clones.remove_unused(x, tracks, std::nullopt);
  ASSERT_EQ(x.state().clones.size(), 4u) << "0, 1, 2 are anchors, 4 has a view";
  clones.remove_unused(x, {}, 4);
  EXPECT_EQ(x.state().clones.size(), 4u);
  clones.remove_unused(x, {}, std::nullopt);
  EXPECT_EQ(x.state().clones.size(), 3u);
}

// A window of two clones is full with its second one. The oldest leaves the window, not the state.
TEST(CloneWindow, ItIsFullAndDropsTheOldest) {
  test::Random random(3);
  SlamContext x = test::some_context(random);
  x.settings.frames_per_clone = 1;
  x.settings.clones = 2;
  CloneWindow clones;
  const auto augment = [&] {
    ++x.frame;
    clones.augment(x, {.time = from_seconds(x.frame), .pixels = {{.landmark = 1}}}, false);
  };
  EXPECT_FALSE(clones.full(x.settings));
  augment();
  EXPECT_FALSE(clones.full(x.settings));
  augment();
  EXPECT_TRUE(clones.full(x.settings));
  EXPECT_EQ(clones.oldest(), x.frame - 1);
  const std::size_t in_state = x.state().clones.size();
  clones.drop_oldest();
  EXPECT_FALSE(clones.full(x.settings));
  EXPECT_EQ(clones.oldest(), x.frame);
  EXPECT_EQ(x.state().clones.size(), in_state);
  augment();
  EXPECT_TRUE(clones.full(x.settings));
  EXPECT_EQ(clones.oldest(), x.frame - 1);
}

TEST(CloneWindow, WithAFixedDepthThereIsNone) {
  test::Random random(4);
  SlamContext x = test::some_context(random);
  x.settings.init = LandmarkInit::kFixedDepth;
  CloneWindow clones;
  clones.augment(x, {.time = from_seconds(10), .pixels = {{.landmark = 1}}}, false);
  EXPECT_FALSE(clones.augmented());
  EXPECT_EQ(x.state().clones.size(), 3u);
}

}  // namespace
}  // namespace chasles
