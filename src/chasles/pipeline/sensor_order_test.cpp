#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include <chasles/pipeline/sensor_order.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/pair_images.hpp>

// Against pair_images() and EventStream's rule, on messages that come in other orders.
namespace chasles {
namespace {

using Events = std::vector<SensorEvent>;
using std::chrono::microseconds;
using std::chrono::milliseconds;

ImuSample sample_at(Time time) { return {.time = time, .specific_force_imu = {0, 0, 9.8}}; }
/// An image that shows its number.
GrayImage numbered(int number) {
  return {.width = 2, .height = 1, .pixels = {static_cast<std::uint8_t>(number), 0}};
}
int number_of(const GrayImage& image) { return image.empty() ? -1 : image.pixels[0]; }

/// A sample (camera -1) or the image `number` of a camera.
struct SensorMessage {
  Time arrival{}, time{};
  int camera = -1, number = 0;
};

/// Half a second of an IMU at 200 Hz and of two cameras at 20 Hz whose stamps jitter. The second
/// camera loses images, and has one that belongs to no frame. Images arrive up to 120 ms late.
std::vector<SensorMessage> messages(std::mt19937& random) {
  std::uniform_int_distribution<int> jitter(-1500, 1500), delay(0, 120'000), third(0, 2);
  std::vector<SensorMessage> all;
  for (int k = 0; k < 100; ++k) {
    const Time time = milliseconds(5 * k);
    all.push_back({.arrival = time, .time = time});
  }
  for (int camera = 0; camera < 2; ++camera) {
    Time free{};  // a topic keeps its order
    for (int k = 0; k < 10; ++k) {
      const Time time = milliseconds(7 + 50 * k) + microseconds(camera == 0 ? 0 : jitter(random));
      free = std::max(free, time + microseconds(delay(random)));
      if (camera == 0 || third(random) != 0) {
        all.push_back({.arrival = free, .time = time, .camera = camera, .number = k});
      }
      if (camera == 1 && k == 3) {
        free = std::max(free, Time(milliseconds(180)));
        all.push_back({.arrival = free, .time = milliseconds(180), .camera = camera, .number = 99});
      }
    }
  }
  std::ranges::stable_sort(all, {}, &SensorMessage::arrival);
  return all;
}

void append_events(Events more, Events& all) {
  for (SensorEvent& event : more) all.push_back(std::move(event));
}

Events ordered(SensorOrder& order, const std::vector<SensorMessage>& all) {
  Events events;
  for (const SensorMessage& m : all) {
    if (m.camera < 0) {
      order.add(sample_at(m.time));
    } else {
      order.add(static_cast<std::size_t>(m.camera), m.time, numbered(m.number));
    }
    append_events(order.take(), events);
  }
  append_events(order.finish(), events);
  return events;
}

/// (time, numbers of both images) of each frame that pair_images() finds.
std::vector<std::pair<Time, std::vector<int>>> expected_frames(std::vector<SensorMessage> all) {
  std::vector<std::vector<Time>> stamps(2);
  std::vector<std::vector<int>> numbers(2);
  std::ranges::stable_sort(all, {}, &SensorMessage::time);
  for (const SensorMessage& m : all) {
    if (m.camera < 0) continue;
    stamps[static_cast<std::size_t>(m.camera)].push_back(m.time);
    numbers[static_cast<std::size_t>(m.camera)].push_back(m.number);
  }
  std::vector<std::string> remarks;
  std::vector<std::pair<Time, std::vector<int>>> frames;
  for (const PairedFrame& frame : pair_images(stamps, {true, false}, kSameInstant, remarks)) {
    std::vector<int> of_frame;
    for (std::size_t c = 0; c < 2; ++c) {
      of_frame.push_back(frame.members[c] ? numbers[c][*frame.members[c]] : -1);
    }
    frames.emplace_back(frame.time, of_frame);
  }
  return frames;
}

/// Before a frame come all samples up to the first that is not earlier, and no other.
void expect_order_of_a_recording(const Events& events) {
  Time before = Time::min(), before_that = Time::min();
  for (const SensorEvent& event : events) {
    if (const auto* sample = std::get_if<ImuSample>(&event)) {
      EXPECT_GT(sample->time, before);
      before_that = std::exchange(before, sample->time);
    } else {
      EXPECT_GT(std::get<ImageFrame>(event).time, before_that);
      EXPECT_LE(std::get<ImageFrame>(event).time, before);
    }
  }
}

TEST(SensorOrder, IsThatOfARecordingWheneverMessagesCome) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<SensorMessage> all = messages(random);
    SensorOrder order({.cameras = 2, .patience = Time::max()});
    const Events events = ordered(order, all);
    std::vector<std::pair<Time, std::vector<int>>> frames;
    for (const SensorEvent& event : events) {
      const auto* frame = std::get_if<ImageFrame>(&event);
      if (frame == nullptr) continue;
      frames.emplace_back(
          frame->time, std::vector<int>{number_of(frame->images[0]), number_of(frame->images[1])});
    }
    EXPECT_EQ(frames, expected_frames(all)) << trial;
    EXPECT_EQ(events.size(), 110u);
    expect_order_of_a_recording(events);
    EXPECT_EQ(order.counts().late_samples + order.counts().late_images, 0);
    EXPECT_EQ(order.counts().unpaired, 1);
  }
}

TEST(SensorOrder, AFrameIsThereWithItsLastImage) {
  SensorOrder order({.cameras = 2});
  order.add(sample_at(milliseconds(0)));
  order.add(0, milliseconds(3), numbered(1));
  EXPECT_EQ(order.take().size(), 1u);  // the sample
  order.add(1, milliseconds(3), numbered(2));
  EXPECT_TRUE(order.take().empty());  // its samples are not there
  order.add(sample_at(milliseconds(5)));
  EXPECT_EQ(order.take().size(), 2u);  // this sample, then the frame
  order.add(sample_at(milliseconds(10)));
  EXPECT_TRUE(order.take().empty());  // an image between 5 and 10 ms may still come
}

TEST(SensorOrder, SortsWhatIsLateAndCountsWhatIsTooLate) {
  SensorOrder order({.cameras = 1});
  for (const int ms : {0, 10, 5, 10}) order.add(sample_at(milliseconds(ms)));
  EXPECT_EQ(order.counts().late_samples, 1);  // 10 twice
  order.add(0, milliseconds(7), numbered(1));
  std::vector<Time> times;
  for (const SensorEvent& event : order.take()) {
    if (const auto* sample = std::get_if<ImuSample>(&event)) times.push_back(sample->time);
  }
  EXPECT_EQ(times, (std::vector<Time>{milliseconds(0), milliseconds(5), milliseconds(10)}));
  order.add(sample_at(milliseconds(8)));
  order.add(0, milliseconds(6), numbered(2));
  EXPECT_TRUE(order.take().empty());
  EXPECT_EQ(order.counts().late_samples, 2);
  EXPECT_EQ(order.counts().late_images, 1);
}

TEST(SensorOrder, LeavesOutSamplesThatAreNotFinite) {
  SensorOrder order({.cameras = 1});
  ImuSample broken = sample_at(milliseconds(1));
  broken.angular_rate_imu.y() = std::numeric_limits<double>::quiet_NaN();
  order.add(broken);
  EXPECT_TRUE(order.finish().empty());
  EXPECT_EQ(order.counts().unknown_samples, 1);
}

TEST(SensorOrder, ASilentCameraOrImuHoldsNothingUpForLong) {
  SensorOrder order({.cameras = 2, .patience = milliseconds(100)});
  std::size_t samples = 0, frames = 0, late_by = 0;
  for (int k = 0; k < 200; ++k) {
    order.add(sample_at(milliseconds(5 * k)));
    if (k % 10 == 0 && k < 100) order.add(0, milliseconds(5 * k), numbered(k));
    for (const SensorEvent& event : order.take()) ++(is_frame(event) ? frames : samples);
    late_by = std::max(late_by, static_cast<std::size_t>(k) + 1 - samples);
  }
  EXPECT_EQ(frames, 10u);
  EXPECT_EQ(order.counts().incomplete, 10);
  EXPECT_LE(late_by, 22u);
  EXPECT_GE(late_by, 20u);
}

// One that dies costs one wait, not one for each frame; when it comes back, frames wait for it.
TEST(SensorOrder, ACameraThatDiesHoldsUpOneFrameOnly) {
  SensorOrder order({.cameras = 2, .patience = milliseconds(100)});
  std::vector<Time> delays;
  int complete = 0;
  const auto dead = [](int k) { return k >= 100 && k < 200; };
  for (int k = 0; k < 300; ++k) {
    const Time now = milliseconds(5 * k);
    order.add(sample_at(now));
    if (k % 10 == 0) order.add(0, now, numbered(k));
    if (k % 10 == 2 && !dead(k))
      order.add(1, now - milliseconds(10), numbered(k));  // arrives later
    for (const SensorEvent& event : order.take()) {
      const auto* frame = std::get_if<ImageFrame>(&event);
      if (frame == nullptr) continue;
      delays.push_back(now - frame->time);
      complete += frame->images[1].empty() ? 0 : 1;
    }
  }
  ASSERT_EQ(delays.size(), 30u);
  EXPECT_EQ(std::ranges::count(delays, milliseconds(105)),
            1);  // of a few frames, one after another
  EXPECT_EQ(delays[10], milliseconds(105));
  EXPECT_EQ(delays[15], milliseconds(0));
  EXPECT_EQ(delays[25], milliseconds(10));
  EXPECT_EQ(complete, 19);  // not that of the frame before its first image again
}

TEST(SensorOrder, ImagesWithoutTheFirstCameraDoNotPileUp) {
  SensorOrder order({.cameras = 2, .patience = milliseconds(100)});
  for (int k = 0; k < 100; ++k) {
    order.add(1, milliseconds(50 * k), numbered(k));
    EXPECT_TRUE(order.take().empty());
  }
  EXPECT_GE(order.counts().unpaired, 96);
}

}  // namespace
}  // namespace chasles
