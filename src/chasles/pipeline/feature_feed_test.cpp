#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/feature_feed.hpp>

namespace chasles {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr Time kImageSpacing = std::chrono::milliseconds(50);

Camera camera() {
  Camera c;
  c.width = kWidth;
  c.height = kHeight;
  c.fx = c.fy = 120;
  c.cx = 80;
  c.cy = 60;
  return c;
}

// An irregular chequered pattern, shifted by `shift` pixels.
GrayImage pattern(double shift) {
  GrayImage image{.width = kWidth, .height = kHeight, .pixels = {}};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double x = u + shift;
      const double value = 120 + 50 * std::sin(0.31 * x + 0.8 * std::sin(0.13 * v)) *
                                     std::sin(0.27 * v + 0.6 * std::sin(0.17 * x));
      image.pixels.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return image;
}

/// 20 images, each after two samples of a gyroscope that measures the rotation of the images plus a
/// bias.
std::function<std::optional<SensorEvent>()> sensors(int images, double bias) {
  return [=, i = 0]() mutable -> std::optional<SensorEvent> {
    const int k = i / 3, part = i % 3;
    if (k >= images) return std::nullopt;
    ++i;
    const Time due = k * kImageSpacing;
    if (part == 2) return ImageFrame{.time = due, .images = {pattern(2.0 * k)}};
    ImuSample sample{.time = due - (part == 0 ? kImageSpacing / 2 : Time(0))};
    sample.angular_rate_imu = {0, 2.0 / 120 / 0.05 + bias, 0};
    return sample;
  };
}

std::vector<FeatureFrame> all_frames(bool ahead, const Eigen::Vector3d& bias) {
  FeatureFeed feed(sensors(20, bias.y()), {}, {camera()}, {}, ahead);
  std::vector<FeatureFrame> frames;
  while (auto item = feed.next()) {
    const auto* tracked = std::get_if<TrackedFrame>(&*item);
    if (!tracked) continue;
    frames.push_back(tracked->frame);
    if (ahead) std::this_thread::sleep_for(std::chrono::milliseconds(frames.size() % 3));
    feed.note_bias(bias);
  }
  return frames;
}

TEST(FeatureFeed, AnImageWithoutACameraIsRejected) {
  FeatureFeed feed(sensors(1, 0), {}, {}, {}, false);
  EXPECT_TRUE(std::holds_alternative<ImuSample>(*feed.next()));
  EXPECT_TRUE(std::holds_alternative<ImuSample>(*feed.next()));
  EXPECT_THROW(feed.next(), InputError);
}

TEST(FeatureFeed, WorksAheadWithTheSameResult) {
  const Eigen::Vector3d bias(0, 0.4, 0);
  const auto inline_frames = all_frames(false, bias);
  const auto ahead = all_frames(true, bias);
  ASSERT_EQ(inline_frames.size(), 20u);
  ASSERT_EQ(ahead.size(), 20u);
  std::size_t followed = 0;
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    EXPECT_EQ(ahead[k].time, inline_frames[k].time);
    ASSERT_EQ(ahead[k].pixels.size(), inline_frames[k].pixels.size());
    for (std::size_t i = 0; i < ahead[k].pixels.size(); ++i) {
      EXPECT_EQ(ahead[k].pixels[i].landmark, inline_frames[k].pixels[i].landmark);
      EXPECT_EQ(ahead[k].pixels[i].pixel, inline_frames[k].pixels[i].pixel);
      followed += k > 0 && ahead[k].pixels[i].landmark == ahead[0].pixels[0].landmark;
    }
  }
  EXPECT_GT(followed, 5u);
}

// Keeps the reference.
auto one_by_one(const std::vector<SensorEvent>& events) {
  return [&events, i = std::size_t{0}]() mutable -> std::optional<SensorEvent> {
    return i < events.size() ? std::optional(events[i++]) : std::nullopt;
  };
}

TEST(FeatureFeed, PassesSamplesAndFramesThroughInOrder) {
  std::vector<SensorEvent> events = {ImuSample{.time = Time(1)}, FeatureFrame{.time = Time(2)},
                                     ImuSample{.time = Time(3)}};
  for (const bool ahead : {false, true}) {
    FeatureFeed feed(one_by_one(events), {}, {camera()}, {}, ahead);
    std::vector<bool> samples;
    while (auto item = feed.next()) samples.push_back(std::holds_alternative<ImuSample>(*item));
    EXPECT_EQ(samples, (std::vector<bool>{true, false, true}));
  }
}

TEST(FeatureFeed, ThrowsWhatTheOtherThreadThrew) {
  for (const bool ahead : {false, true}) {
    int i = 0;
    FeatureFeed feed(
        [&]() -> std::optional<SensorEvent> {
          if (i++ > 0) throw InputError("torn");
          return ImuSample{.time = Time(1)};
        },
        {}, {camera()}, {}, ahead);
    EXPECT_TRUE(feed.next());
    EXPECT_THROW(feed.next(), InputError);
  }
}

// The worker waits for a bias that never comes; the feed can still be destroyed.
TEST(FeatureFeed, CanBeLetGoWhileItsThreadWaits) {
  FeatureFeed feed(sensors(20, 0), {}, {camera()}, {}, true);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(feed.next());
}

// Data that a live sensor may deliver and a reader does not; the front end does not receive them.
TEST(FeatureFeed, BearsImagesThatAreNotLaterAndAbsurdRates) {
  const Time step = std::chrono::milliseconds(50);
  std::vector<SensorEvent> events;
  for (const int k : {1, 2, 2, 1, 3, 4}) {
    ImuSample sample{.time = k * step};
    sample.angular_rate_imu.setConstant(k == 3 ? 1e300 : 0.1);
    events.emplace_back(sample);
    events.emplace_back(ImageFrame{.time = k * step, .images = {GrayImage{}}});
  }
  for (const bool ahead : {false, true}) {
    FeatureFeed feed(one_by_one(events), {}, {camera()}, {}, ahead);
    std::vector<Time> times;
    while (auto item = feed.next()) {
      const auto* tracked = std::get_if<TrackedFrame>(&*item);
      if (!tracked) continue;
      times.push_back(tracked->frame.time);
      EXPECT_EQ(tracked->report.missing_images, times.size() == 3 || times.size() == 4 ? 0 : 1);
      feed.note_bias(Eigen::Vector3d::Zero());
    }
    EXPECT_EQ(times, (std::vector{step, 2 * step, 2 * step, step, 3 * step, 4 * step}));
  }
}

}  // namespace
}  // namespace chasles
