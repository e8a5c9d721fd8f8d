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

}  // namespace
}  // namespace chasles
