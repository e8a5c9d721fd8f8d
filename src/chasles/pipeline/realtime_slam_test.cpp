#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/realtime_slam.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

using test::Estimates;

const Recording& short_walk() {
  static const Recording recording = [] {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.hall_length = 6;
    s.sections = 1;
    s.rest_duration = 1;
    s.frame_rate = 10;
    s.focal_length = 160;
    s.image_width = 240;
    s.image_height = 180;
    s.center_u = 119.5;
    s.center_v = 89.5;
    return render_inertial(scene);
  }();
  return recording;
}

std::unique_ptr<VisualInertialSlam> slam_of(const char* estimator = "filter") {
  InertialRunSettings settings;
  settings.estimator = estimator_choice(estimator);
  return std::make_unique<VisualInertialSlam>(
      short_walk().cameras, *short_walk().imu_noise, settings,
      ImuBuffer::Options{.convention = short_walk().imu_convention});
}

template <typename Slam, typename Each>
void feed(Slam& slam, const Each& each) {
  EventStream events(short_walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) each(slam.process(*sample));
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) each(slam.process(short_walk().images->read(due->index)));
  }
}

Estimates blocking(const char* estimator = "filter") {
  const auto slam = slam_of(estimator);
  Estimates all;
  feed(*slam, [&](Estimates some) { append(std::move(some), all); });
  append(slam->finish(), all);
  return all;
}

// process() of a sample returns nothing, and that of images a number.
void play_on(RealtimeSlam& slam) {
  EventStream events(short_walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) slam.process(short_walk().images->read(due->index));
  }
}

void expect_same_bytes(const Estimates& a, const Estimates& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].time, b[i].time);
    EXPECT_EQ(a[i].world_T_imu.p, b[i].world_T_imu.p) << i;
    EXPECT_EQ(a[i].covariance, b[i].covariance) << i;
  }
}

TEST(RealtimeSlam, GivesTheBytesOfTheBlockingCalls) {
  for (const char* estimator : {"filter", "window:5", "batch"}) {
    Estimates all;
    RealtimeSlam slam(slam_of(estimator), {.most_images = 0},
                      [&](std::span<const Estimate> some, VisualInertialSlam&) {
                        all.insert(all.end(), some.begin(), some.end());
                      });
    play_on(slam);
    append(slam.finish(), all);
    expect_same_bytes(all, blocking(estimator));
    const RealtimeSlam::Counts counts = slam.counts();
    EXPECT_EQ(counts.came, short_walk().images->size());
    EXPECT_EQ(counts.taken, counts.came);
    EXPECT_EQ(counts.dropped + counts.waiting, 0u);
  }
}

TEST(RealtimeSlam, SamplesMayAllComeBeforeTheImages) {
  Estimates all;
  RealtimeSlam slam(slam_of(), {.most_images = 0},
                    [&](std::span<const Estimate> some, VisualInertialSlam&) {
                      all.insert(all.end(), some.begin(), some.end());
                    });
  for (const ImuSample& sample : short_walk().imu) slam.process(sample);
  slam.process(short_walk().imu.front());  // once more
  for (std::size_t i = 0; i < short_walk().images->size(); ++i) {
    slam.process(short_walk().images->read(i));
  }
  append(slam.finish(), all);
  expect_same_bytes(all, blocking());
  EXPECT_EQ(slam.arrivals().samples, short_walk().imu.size() + 1);
  EXPECT_EQ(slam.arrivals().samples_late, 1u);
  EXPECT_EQ(slam.arrivals().images, short_walk().images->size());
  EXPECT_EQ(slam.arrivals().images_uncovered + slam.arrivals().images_late, 0u);
}

TEST(RealtimeSlam, PredictsWhatTheBlockingOnePredicts) {
  const auto expected = slam_of();
  RealtimeSlam slam(slam_of(), {.most_images = 0});
  feed(*expected, [](const Estimates&) {});
  play_on(slam);
  EXPECT_TRUE(slam.finish().empty());
  const Time end = short_walk().imu.back().time;
  for (const int ms : {-5, 0, 7, 100}) {
    const Time time = end + std::chrono::milliseconds(ms);
    const auto a = slam.predicted(time), b = expected->predicted(time);
    ASSERT_TRUE(a && b) << ms;
    EXPECT_EQ(a->state.world_T_imu.p, b->state.world_T_imu.p);
    EXPECT_EQ(a->covariance, b->covariance);
    EXPECT_GT(a->since_estimate, Time{});
  }
}

// The estimator is blocked, and the calls return all the same: the oldest images give way.
TEST(RealtimeSlam, DropsTheOldestImagesWhereTheEstimatorIsTooSlow) {
  std::mutex mutex;
  std::condition_variable changed;
  bool go_on = false, stands = false;
  Estimates all;
  RealtimeSlam slam(slam_of(), {.most_images = 2},
                    [&](std::span<const Estimate> some, VisualInertialSlam&) {
                      std::unique_lock lock(mutex);
                      all.insert(all.end(), some.begin(), some.end());
                      stands = true;
                      changed.notify_all();
                      changed.wait(lock, [&] { return go_on; });
                    });
  // Until the first estimate all images must arrive.
  EventStream events(short_walk());
  std::size_t displaced = 0, came = 0;
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (!due) continue;
    ++came;
    displaced += slam.process(short_walk().images->read(due->index));
    std::unique_lock lock(mutex);
    if (stands) continue;
    changed.wait_for(lock, std::chrono::milliseconds(300),
                     [&] { return stands || slam.counts().waiting == 0; });
  }
  const RealtimeSlam::Counts counts = slam.counts();
  EXPECT_EQ(counts.came, came);
  EXPECT_EQ(counts.waiting, 2u);
  EXPECT_EQ(counts.dropped, displaced);
  EXPECT_GT(counts.dropped, 20u);
  EXPECT_EQ(counts.came, counts.taken + counts.dropped + counts.waiting);
  {
    const std::lock_guard lock(mutex);
    go_on = true;
    changed.notify_all();
  }
  slam.finish();
  // The last two images are the newest ones.
  ASSERT_GE(all.size(), 3u);
  const Time last = short_walk().images->time(short_walk().images->size() - 1);
  EXPECT_NEAR(to_seconds(all.back().time), to_seconds(last), 0.02);  // and the time offset
}

// The caller is held up instead, and no more images than stated are in memory.
TEST(RealtimeSlam, WaitsForRoomAndDropsNothing) {
  Estimates all;
  std::size_t most = 0;
  RealtimeSlam slam(slam_of(), {.most_images = 2, .waits_for_room = true},
                    [&](std::span<const Estimate> some, VisualInertialSlam&) {
                      all.insert(all.end(), some.begin(), some.end());
                    });
  EventStream events(short_walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) slam.process(short_walk().images->read(due->index));
    most = std::max(most, slam.counts().waiting);
  }
  append(slam.finish(), all);
  EXPECT_LE(most, 2u);
  expect_same_bytes(all, blocking());
}

TEST(RealtimeSlam, AnErrorEndsTheWaitForRoom) {
  RealtimeSlam slam(slam_of(), {.most_images = 1, .waits_for_room = true},
                    [](std::span<const Estimate>, VisualInertialSlam&) {
                      throw std::runtime_error("the program's own");
                    });
  EXPECT_THROW(play_on(slam), std::runtime_error);
}

TEST(RealtimeSlam, AnswersQuestionsBetweenEvents) {
  RealtimeSlam slam(slam_of(), {.most_images = 0});
  play_on(slam);
  std::size_t landmarks = 0;
  slam.ask([&](VisualInertialSlam& s) { landmarks = s.estimator().map().size(); });
  slam.finish();
  std::size_t at_the_end = 0;
  slam.ask([&](VisualInertialSlam& s) { at_the_end = s.estimator().map().size(); });
  EXPECT_GE(at_the_end, landmarks);
  EXPECT_GT(at_the_end, 10u);
  EXPECT_THROW(slam.ask([](VisualInertialSlam&) { throw InputError("why"); }), InputError);
  EXPECT_THROW(slam.process(short_walk().imu.back()), UsageError);
  EXPECT_THROW(slam.process(short_walk().images->read(0)), UsageError);
}

TEST(RealtimeSlam, AnErrorEndsTheWorkAndIsReportedToTheCaller) {
  RealtimeSlam slam(slam_of(), {.most_images = 0},
                    [](std::span<const Estimate>, VisualInertialSlam&) {
                      throw std::runtime_error("the program's own");
                    });
  EXPECT_THROW(
      {
        play_on(slam);
        slam.finish();
      },
      std::runtime_error);
  EXPECT_THROW(slam.process(short_walk().imu.back()), std::runtime_error);
  EXPECT_THROW(slam.ask([](VisualInertialSlam&) {}), std::runtime_error);
  EXPECT_TRUE(slam.failure());
  std::size_t landmarks = 0;
  slam.ask_in_any_case([&](VisualInertialSlam& s) { landmarks = s.estimator().map().size(); });
  EXPECT_GT(landmarks, 0u);
}

TEST(RealtimeSlam, FinishStopsOnRequestAndMayBeCalledAgain) {
  std::timed_mutex turn;
  RealtimeSlam slam(slam_of(), {.most_images = 0, .turn = &turn});
  {
    const std::lock_guard others(turn);
    play_on(slam);
    EXPECT_TRUE(slam.finish([] { return true; }).empty());
    EXPECT_GT(slam.counts().waiting, 0u);
  }
  slam.finish();
  EXPECT_EQ(slam.counts().taken, short_walk().images->size());
}

TEST(RealtimeSlam, ImagesOfAnotherRigAreRejectedAtOnce) {
  RealtimeSlam slam(slam_of(), {});
  ImageFrame images = short_walk().images->read(0);
  images.images[0].height /= 2;
  images.images[0].pixels.resize(images.images[0].pixels.size() / 2);
  EXPECT_THROW(slam.process(images), InputError);
  EXPECT_EQ(slam.counts().came, 0u);
}

// The destructor does not wait for what has not started.
TEST(RealtimeSlam, EndsWithoutWaitingForAllThatCame) {
  RealtimeSlam slam(slam_of(), {.most_images = 0});
  play_on(slam);
}

TEST(RealtimeSlam, AStopEndsTheLastSmoothing) {
  RealtimeSlam slam(slam_of("batch"), {.most_images = 0});
  play_on(slam);
  const auto all_are_taken = [&] {
    const RealtimeSlam::Counts n = slam.counts();
    return n.waiting == 0 && n.taken == n.came;
  };
  EXPECT_TRUE(slam.finish(all_are_taken).empty());
}

}  // namespace
}  // namespace chasles
