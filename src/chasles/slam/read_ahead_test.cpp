#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include <chasles/error.hpp>
#include <chasles/slam/read_ahead.hpp>

namespace chasles {
namespace {

constexpr Time kSpacing = std::chrono::milliseconds(50);

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

TEST(ReadAhead, GivesTheSameEventsInTheSameOrder) {
  std::atomic<int> read = 0;
  ReadAhead ahead(sensors(50, read));
  for (int i = 0; i < 200; ++i) {
    const auto event = ahead.next();
    ASSERT_TRUE(event) << i;
    EXPECT_EQ(time_of(*event), i * kSpacing);
    EXPECT_EQ(std::holds_alternative<ImageFrame>(*event), i % 4 == 3);
  }
  EXPECT_FALSE(ahead.next());
  EXPECT_FALSE(ahead.next()) << "the end stays the end";
}

TEST(ReadAhead, ReadsAFewImagesAheadAndNoMore) {
  std::atomic<int> read = 0;
  ReadAhead ahead(sensors(50, read));
  const int most = static_cast<int>(ReadAhead::kImages);
  while (read < most) std::this_thread::yield();
  int taken = 0;
  while (const auto event = ahead.next()) {
    taken += std::holds_alternative<ImageFrame>(*event);
    EXPECT_LE(read, taken + most);
  }
  EXPECT_EQ(taken, 50);
}

TEST(ReadAhead, MayEndBeforeItsReader) {
  std::atomic<int> read = 0;
  ReadAhead ahead(sensors(50, read));
  EXPECT_TRUE(ahead.next());
  while (read < static_cast<int>(ReadAhead::kImages)) std::this_thread::yield();
}  // and now the reader waits for room

TEST(ReadAhead, ThrowsWhatTheReaderThrewAfterWhatCameBefore) {
  std::atomic<int> read = 0;
  ReadAhead ahead([&, next = sensors(2, read)]() mutable {
    auto event = next();
    if (!event) throw InputError("torn");
    return event;
  });
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(ahead.next());
  EXPECT_THROW(ahead.next(), InputError);
  EXPECT_FALSE(ahead.next());
}

}  // namespace
}  // namespace chasles
