#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/ahead.hpp>
#include <chasles/pipeline/feature_feed.hpp>

namespace chasles {
namespace {

constexpr Time kSpacing = std::chrono::milliseconds(50);
constexpr int kMost = 4;  // maximum number of images that wait

/// `images` images, each after three samples; `read` counts the images.
std::function<std::optional<SensorEvent>()> sensors(int images, std::atomic<int>& read) {
  return [=, &read, i = 0]() mutable -> std::optional<SensorEvent> {
    if (i >= 4 * images) return std::nullopt;
    const Time time = i * kSpacing;
    if (i++ % 4 != 3) return ImuSample{.time = time};
    ++read;
    return ImageFrame{.time = time, .images = {}};
  };
}

Time time_of(const SensorEvent& event) {
  return std::visit([](const auto& e) { return e.time; }, event);
}

bool is_image(const SensorEvent& event) { return std::holds_alternative<ImageFrame>(event); }

TEST(Ahead, GivesTheSameInTheSameOrder) {
  std::atomic<int> read = 0;
  Ahead<SensorEvent> ahead(sensors(50, read), is_image, kMost);
  for (int i = 0; i < 200; ++i) {
    const auto event = ahead.next();
    ASSERT_TRUE(event) << i;
    EXPECT_EQ(time_of(*event), i * kSpacing);
    EXPECT_EQ(is_image(*event), i % 4 == 3);
  }
  EXPECT_FALSE(ahead.next());
  EXPECT_FALSE(ahead.next()) << "the end stays the end";
}

TEST(Ahead, MakesAFewAheadAndNoMore) {
  std::atomic<int> read = 0;
  Ahead<SensorEvent> ahead(sensors(50, read), is_image, kMost);
  while (read < kMost) std::this_thread::yield();
  int taken = 0;
  while (const auto event = ahead.next()) {
    taken += is_image(*event);
    EXPECT_LE(read, taken + kMost);
  }
  EXPECT_EQ(taken, 50);
}

TEST(Ahead, MayEndBeforeItsMaker) {
  std::atomic<int> read = 0;
  Ahead<SensorEvent> ahead(sensors(50, read), is_image, kMost);
  EXPECT_TRUE(ahead.next());
  while (read < kMost) std::this_thread::yield();
}  // and now the other thread waits for room

TEST(Ahead, ThrowsWhatItsMakerThrewAfterWhatCameBefore) {
  std::atomic<int> read = 0;
  const auto torn = [&, next = sensors(2, read)]() mutable {
    auto event = next();
    if (!event) throw InputError("torn");
    return event;
  };
  Ahead<SensorEvent> ahead(torn, is_image, kMost);
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(ahead.next());
  EXPECT_THROW(ahead.next(), InputError);
  EXPECT_FALSE(ahead.next());
}

}  // namespace
}  // namespace chasles
