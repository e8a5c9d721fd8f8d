#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/reconstruct/keyframes.hpp>

namespace chasles {
namespace {

using Indices = std::vector<std::size_t>;

// Frames that turn by `degrees` and move by `metres` each, all with the same tracks.
std::vector<KeyframeCandidate> frames_of(std::size_t count, double degrees, double metres) {
  std::vector<KeyframeCandidate> frames(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    frames[i] = {.world_T_imu = {so3::exp({0, 0, k * degrees * kRadians}), {k * metres, 0, 0}},
                 .sharpness = 1,
                 .tracks = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
  }
  return frames;
}

TEST(Keyframes, ADueOneComesByRotationDistanceOrOverlap) {
  ColmapSettings settings{.rotation = 9.5, .search = 0};
  EXPECT_EQ(choose_keyframes(frames_of(25, 1, 0.1), settings), (Indices{0, 10, 20}));
  EXPECT_EQ(choose_keyframes(frames_of(25, 0, 0.1), settings), Indices{0});
  settings.distance = 0.55;
  EXPECT_EQ(choose_keyframes(frames_of(25, 1, 0.1), settings), (Indices{0, 6, 12, 18, 24}));
  settings.distance.reset();
  settings.overlap = 0.7;
  auto frames = frames_of(25, 0, 0);
  // Each frame has lost one track of ten: three are gone after three.
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (LandmarkId& id : frames[i].tracks) id += static_cast<LandmarkId>(i);
  }
  EXPECT_EQ(choose_keyframes(frames, settings), (Indices{0, 3, 6, 9, 12, 15, 18, 21, 24}));
}

TEST(Keyframes, TheSharpestSoonAfterTheDueOneIsTaken) {
  auto frames = frames_of(25, 1, 0);
  frames[12].sharpness = 1.5;
  frames[16].sharpness = 2;  // too late
  const ColmapSettings settings{.rotation = 9.5, .search = 0.45};
  EXPECT_EQ(choose_keyframes(frames, settings), (Indices{0, 12, 22}));
}

TEST(Keyframes, ABlurredOneIsNone) {
  auto frames = frames_of(25, 1, 0);
  frames[0].sharpness = frames[10].sharpness = 0.3;
  const ColmapSettings settings{.rotation = 9.5, .search = 0, .min_sharpness = 0.5};
  EXPECT_EQ(choose_keyframes(frames, settings), (Indices{1, 11, 21}));
  for (KeyframeCandidate& frame : frames) frame.sharpness = 0.1;
  EXPECT_TRUE(choose_keyframes(frames, settings).empty());
}

TEST(Keyframes, AFrameWithoutTracksHasNoOverlap) {
  auto frames = frames_of(3, 0, 0);
  for (KeyframeCandidate& frame : frames) frame.tracks.clear();
  EXPECT_EQ(choose_keyframes(frames, {.search = 0}), (Indices{0, 1, 2}));
}

}  // namespace
}  // namespace chasles
