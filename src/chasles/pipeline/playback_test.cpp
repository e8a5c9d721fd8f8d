#include <atomic>
#include <chrono>
#include <deque>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/feature_feed.hpp>
#include <chasles/pipeline/playback.hpp>

namespace chasles {
namespace {

using NextEvent = std::function<std::optional<SensorEvent>()>;
constexpr Time kBegin = std::chrono::seconds(1000);
constexpr Time kPlaybackSpacing = std::chrono::milliseconds(50);
constexpr Time kHour = std::chrono::hours(1);

/// A clock that is set by hand.
class HandClock {
 public:
  PlaybackClock clock() {
    return {.now = [this] { return Time(now_.load()); },
            .wait_for = [](Time) { std::this_thread::sleep_for(std::chrono::microseconds(50)); }};
  }
  void set(Time since_start) { now_ = kStart + since_start.count(); }

 private:
  static constexpr Time::rep kStart = 77'000'000'000;
  std::atomic<Time::rep> now_ = kStart;
};

/// `frames` frames, kPlaybackSpacing apart, each after a sample of the same time.
NextEvent sensors(int frames) {
  return [=, i = 0]() mutable -> std::optional<SensorEvent> {
    if (i >= 2 * frames) return std::nullopt;
    const Time time = kBegin + (i / 2) * kPlaybackSpacing;
    if (i++ % 2 == 0) return ImuSample{.time = time};
    return FeatureFrame{.time = time};
  };
}

void wait_until_came(const Playback& playback, std::size_t frames) {
  while (playback.counts().came < frames) std::this_thread::yield();
}

/// The time of the next frame, or none; all events before it must be samples, in order.
std::optional<Time> next_frame(Playback& playback, int& samples) {
  while (auto event = playback.next()) {
    if (const auto* frame = std::get_if<FeatureFrame>(&*event)) return frame->time;
    EXPECT_EQ(std::get<ImuSample>(*event).time, kBegin + samples * kPlaybackSpacing);
    ++samples;
  }
  return std::nullopt;
}

TEST(Playback, GivesEachEventAtItsTimeAndNotBefore) {
  HandClock hand;
  Playback playback(sensors(20), {.begin = kBegin, .waiting = 1, .clock = hand.clock()});
  int samples = 0;
  for (int k = 0; k < 20; ++k) {
    hand.set(k * kPlaybackSpacing);
    EXPECT_EQ(next_frame(playback, samples), kBegin + k * kPlaybackSpacing);
    EXPECT_EQ(playback.counts().came, static_cast<std::size_t>(k + 1));
    EXPECT_DOUBLE_EQ(playback.seconds_since(kBegin), to_seconds(k * kPlaybackSpacing));
  }
  EXPECT_EQ(next_frame(playback, samples), std::nullopt);
  EXPECT_EQ(samples, 20);
  EXPECT_EQ(playback.counts().taken, 20u);
  EXPECT_EQ(playback.counts().dropped, 0u);
}

TEST(Playback, AtTwiceTheSpeedTwiceAsMuchIsDue) {
  HandClock hand;
  Playback playback(sensors(20),
                    {.begin = kBegin, .speed = 2, .waiting = 20, .clock = hand.clock()});
  int samples = 0;
  hand.set(3 * kPlaybackSpacing);
  for (int k = 0; k <= 6; ++k) EXPECT_TRUE(next_frame(playback, samples));
  EXPECT_EQ(playback.counts().came, 7u);
  EXPECT_DOUBLE_EQ(playback.seconds_since(kBegin + 4 * kPlaybackSpacing),
                   to_seconds(kPlaybackSpacing));
  EXPECT_DOUBLE_EQ(playback.seconds_since(kBegin + 8 * kPlaybackSpacing),
                   -to_seconds(kPlaybackSpacing));
}

// A consumer that takes nothing until the end still gets the oldest frames and every sample.
TEST(Playback, DropsFramesThatComeWhileTooManyWait) {
  HandClock hand;
  Playback playback(sensors(20), {.begin = kBegin, .waiting = 3, .clock = hand.clock()});
  hand.set(kHour);
  wait_until_came(playback, 20);
  int samples = 0;
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(next_frame(playback, samples), kBegin + k * kPlaybackSpacing);
  EXPECT_EQ(next_frame(playback, samples), std::nullopt);
  EXPECT_EQ(samples, 20);
  EXPECT_EQ(playback.counts().taken, 3u);
  EXPECT_EQ(playback.counts().dropped, 17u);
}

// A filter that needs three frame intervals per frame, against a queue computed by hand.
TEST(Playback, OfASlowFilterAccountsForEveryFrame) {
  HandClock hand;
  Playback playback(sensors(60), {.begin = kBegin, .waiting = 2, .clock = hand.clock()});
  std::deque<Time> queue;
  std::vector<Time> expected, found;
  std::size_t dropped = 0;
  int samples = 0;
  for (int k = 0; k < 60; ++k) {
    hand.set(k * kPlaybackSpacing);
    wait_until_came(playback, static_cast<std::size_t>(k + 1));
    if (queue.size() < 2) {
      queue.push_back(kBegin + k * kPlaybackSpacing);
    } else {
      ++dropped;
    }
    if (k % 3 != 2) continue;
    expected.push_back(queue.front());
    queue.pop_front();
    found.push_back(next_frame(playback, samples).value_or(Time(0)));
  }
  while (auto time = next_frame(playback, samples)) found.push_back(*time);
  expected.insert(expected.end(), queue.begin(), queue.end());
  EXPECT_EQ(found, expected);
  EXPECT_GT(dropped, 30u);
  EXPECT_EQ(playback.counts().dropped, dropped);
  EXPECT_EQ(playback.counts().taken + dropped, 60u);
  EXPECT_EQ(samples, 60);
}

TEST(Playback, EndsWhenItIsStopped) {
  HandClock hand;
  Playback playback(sensors(20), {.begin = kBegin, .waiting = 3, .clock = hand.clock()});
  hand.set(4 * kPlaybackSpacing);
  wait_until_came(playback, 5);
  int samples = 0;
  EXPECT_TRUE(next_frame(playback, samples));
  std::thread other([&] { playback.stop(); });
  other.join();
  EXPECT_FALSE(playback.next());
  const Playback::Counts counts = playback.counts();
  EXPECT_EQ(counts.came, counts.taken + counts.dropped);
  EXPECT_EQ(counts.taken, 1u);
}

// The next frame is due in an hour; a waiting consumer still receives the interrupt.
TEST(Playback, EndsWhenItIsInterruptedWhileSomebodyWaits) {
  std::atomic<bool> interrupted = false;
  Playback playback(sensors(2),
                    {.begin = kBegin - kHour, .stop = [&] { return interrupted.load(); }});
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    interrupted = true;
  });
  EXPECT_FALSE(playback.next());
  other.join();
  EXPECT_EQ(playback.counts().came, 0u);
}

TEST(Playback, CanBeLetGoBeforeItsEnd) {
  const Playback playback(sensors(2), {.begin = kBegin - kHour});
  EXPECT_LT(playback.seconds_since(kBegin), -3000);
}

TEST(Playback, ThrowsWhatTheOtherThreadThrewAfterWhatCameBefore) {
  HandClock hand;
  Playback playback(
      [i = 0]() mutable -> std::optional<SensorEvent> {
        if (i++ > 0) throw InputError("torn");
        return FeatureFrame{.time = kBegin};
      },
      {.begin = kBegin, .clock = hand.clock()});
  EXPECT_TRUE(playback.next());
  EXPECT_THROW(playback.next(), InputError);
  EXPECT_FALSE(playback.next());
}

Camera small_camera() {
  Camera c;
  c.width = 64;
  c.height = 48;
  c.fx = c.fy = 50;
  c.cx = 32;
  c.cy = 24;
  return c;
}

// A grey image has no points; other tests cover tracking.
NextEvent images(int count) {
  return [=, i = 0]() mutable -> std::optional<SensorEvent> {
    if (i >= count) return std::nullopt;
    const GrayImage grey{
        .width = 64, .height = 48, .pixels = std::vector<std::uint8_t>(64 * 48, 99)};
    return ImageFrame{.time = kBegin + kPlaybackSpacing * i++, .images = {grey}};
  };
}

// The clock advances only after a frame is processed, by four frame intervals at once.
TEST(Playback, ThroughAFrontEndEveryImageIsTrackedOrDropped) {
  for (const bool ahead : {false, true}) {
    HandClock hand;
    Playback playback(images(101), {.begin = kBegin, .waiting = 3, .clock = hand.clock()});
    std::vector<Time> times;
    {
      FeatureFeed feed([&] { return playback.next(); }, {}, {small_camera()}, {}, ahead);
      for (int now = 4; auto item = feed.next(); now += 4) {
        times.push_back(std::get<TrackedFrame>(*item).frame.time);
        hand.set(now * kPlaybackSpacing);
        wait_until_came(playback, std::min<std::size_t>(now + 1, 101));
        feed.note_bias(Eigen::Vector3d::Zero());
      }
    }
    EXPECT_EQ(playback.counts().came, 101u);
    EXPECT_EQ(playback.counts().taken, times.size());
    EXPECT_EQ(playback.counts().taken + playback.counts().dropped, 101u);
    EXPECT_GT(playback.counts().dropped, 10u);
    EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  }
}

}  // namespace
}  // namespace chasles
