#include <gtest/gtest.h>

#include <chasles/estimate/recent_tracks.hpp>

namespace chasles {
namespace {

TEST(RecentTracks, UpdatesCountForTheLastFrames) {
  RecentTracks tracks(3, 100);
  tracks.note(true);
  tracks.note(true);
  tracks.note(false);
  for (int frame = 0; frame < 3; ++frame) {
    const TrackUse use = tracks.end_frame(5);
    EXPECT_EQ(use.used, 2) << frame;
    EXPECT_EQ(use.rejected, 1) << frame;
    EXPECT_EQ(use.waiting, 5) << frame;
  }
  EXPECT_EQ(tracks.end_frame(5).used, 0);
  EXPECT_EQ(tracks.end_frame(5).rejected, 0);
}

TEST(RecentTracks, TracksThatWaitLongerThanAWindowDoNotCount) {
  RecentTracks tracks(1, 10);
  for (int frame = 0; frame < 10; ++frame) EXPECT_EQ(tracks.end_frame(7).waiting, 7) << frame;
  tracks.note(false);  // rejected, so no update
  EXPECT_EQ(tracks.end_frame(7).waiting, 0);
  tracks.note(true);
  EXPECT_EQ(tracks.end_frame(7).waiting, 7);
}

// As after seconds in the dark: the wait begins with the first track that waits.
TEST(RecentTracks, WhereNoneWaitsNoneWaitsInVain) {
  RecentTracks tracks(1, 10);
  for (int frame = 0; frame < 30; ++frame) tracks.end_frame(0);
  for (int frame = 0; frame < 10; ++frame) EXPECT_EQ(tracks.end_frame(7).waiting, 7) << frame;
  EXPECT_EQ(tracks.end_frame(7).waiting, 0);
}

}  // namespace
}  // namespace chasles
