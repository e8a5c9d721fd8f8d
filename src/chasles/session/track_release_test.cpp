#include <algorithm>

#include <gtest/gtest.h>

#include <chasles/session/track_release.hpp>

namespace chasles {
namespace {

Recording three_frames() {
  Recording recording;
  for (int i = 0; i < 3; ++i) {
    recording.frames.push_back(
        {.time = Time(i), .observations = {{.landmark = i}}, .pixels = {{.landmark = i}}});
  }
  return recording;
}

bool is_released(const FeatureFrame& frame) {
  return frame.observations.empty() && frame.pixels.empty();
}

TEST(TrackRelease, KeepsAllTracksUntilTheFirstEstimate) {
  Recording recording = three_frames();
  TrackRelease release(recording);
  release.on_frame({.time = Time(0)});
  release.on_frame({.time = Time(1)});
  EXPECT_TRUE(std::ranges::none_of(recording.frames, is_released));
}

TEST(TrackRelease, ReleasesThoseUpToTheFrameAndKeepsTheTimes) {
  Recording recording = three_frames();
  TrackRelease release(recording);
  release.on_estimate({}, {});
  release.on_frame({.time = Time(1)});  // in real time, frames may be dropped
  EXPECT_TRUE(is_released(recording.frames[0]));
  EXPECT_TRUE(is_released(recording.frames[1]));
  EXPECT_FALSE(is_released(recording.frames[2]));
  ASSERT_EQ(frame_count(recording), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(recording.frames[static_cast<std::size_t>(i)].time, Time(i));
  EXPECT_EQ(recording.frames[0].pixels.capacity(), 0u);
}

}  // namespace
}  // namespace chasles
