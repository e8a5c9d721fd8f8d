#include <gtest/gtest.h>

#include <chasles/recording/recording.hpp>

namespace chasles {
namespace {

TEST(FrameInterval, IsThatOfTheCamerasOwnFrames) {
  Recording r;
  for (int k = 0; k < 9; ++k) {
    r.frames.push_back({.time = std::chrono::milliseconds(10 * k),
                        .pixels = {{.landmark = 1, .camera = k % 3 == 0 ? 0 : 1}}});
  }
  ASSERT_TRUE(frame_interval(r, 0) && frame_interval(r, 1));
  EXPECT_NEAR(*frame_interval(r, 0), 0.03, 1e-9);
  EXPECT_NEAR(*frame_interval(r, 1), 0.01, 1e-9);
  EXPECT_FALSE(frame_interval(r, 2)) << "without a frame";
}

}  // namespace
}  // namespace chasles
