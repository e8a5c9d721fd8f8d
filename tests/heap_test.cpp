#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/body_velocity_model.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/stereo_measurement.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session.hpp>

#include "heap_count.hpp"

// What a run takes from the heap, a frame at a time and over ten minutes.
namespace chasles::test {
namespace {

// Calls of the heap in a frame of the filter below; measured: 6 and 109.
constexpr long kPropagationLimit = 10, kUpdateLimit = 150;

TEST(HeapCount, SeesWhatEachWayTakesAndGivesBack) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  const HeapCount before = heap_count();
  auto* numbers = new std::vector<double>(1000);
  auto* matrix = new Eigen::MatrixXd(100, 100);
  const HeapCount during = heap_count();
  EXPECT_EQ(during.allocations - before.allocations, 4);
  EXPECT_GE(during.live_bytes - before.live_bytes, 88000);
  EXPECT_LT(during.live_bytes - before.live_bytes, 89000);
  delete numbers;
  delete matrix;
  EXPECT_EQ(heap_count().live_bytes, before.live_bytes);
}

StereoRig rig() {
  StereoRig rig{.fx = 700, .fy = 700, .cx = 600, .cy = 180, .baseline = 0.5, .cam0_T_imu = {}};
  rig.cam0_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return rig;
}

StereoObservation observe(LandmarkId id) {
  const double disparity = 5 + static_cast<double>(id % 23);
  const double u = 100 + static_cast<double>((id * 37) % 1000);
  const double v = 20 + static_cast<double>((id * 17) % 320);
  return {.landmark = id, .pixels = {u, v, u - disparity, v}};
}

/// 50 landmarks in the state, seen again and again by a camera that stands.
class Standing {
 public:
  Standing() : filter_(error_chart("right-sen3"), initial(), covariance(), options()) {
    noise_.walk.setConstant(0.1);
    noise_.sample_sigma.setConstant(0.1);
    std::vector<NewLandmark> landmarks;
    for (LandmarkId id = 0; id < 50; ++id) {
      landmarks.push_back(*begin_landmark(rig_, kPixels, filter_.state(), observe(id)));
    }
    filter_.add(landmarks);
    for (int i = 0; i < 50; ++i) {
      const auto id = static_cast<LandmarkId>(i);
      measurements_.push_back(
          *measure_stereo(rig_, StereoRows::kMean, kPixels, filter_.state(), i, observe(id)));
    }
  }
  void predict_and_propagate() {
    filter_.propagate(predict(model_, filter_.state(), {}, 0.05, noise_));
  }
  UpdateReport update() { return filter_.update(measurements_); }

 private:
  static constexpr StereoNoise kPixels{.u = 1, .v = 1, .disparity = 0.5};
  static Ekf::Options options() { return {.compress_map = true, .keep_map = false}; }
  static State initial() {
    State x;
    x.additive = Eigen::VectorXd::Zero(BodyVelocityModel{}.size());
    return x;
  }
  static Eigen::MatrixXd covariance() {
    const int n = 6 + BodyVelocityModel{}.size();
    return 0.01 * Eigen::MatrixXd::Identity(n, n);
  }

  BodyVelocityModel model_;
  BodyVelocityNoise noise_;
  StereoRig rig_ = rig();
  Ekf filter_;
  std::vector<Measurement> measurements_;
};

// Nothing is kept of a frame; how often the heap is asked does not grow either.
TEST(Heap, OfAFilterWithAConstantStateStaysAsItIs) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  Standing filter;
  const auto frames = [&](int count) {
    long propagate = 0, update = 0;
    for (int i = 0; i < count; ++i) {
      const long start = heap_count().allocations;
      filter.predict_and_propagate();
      const long between = heap_count().allocations;
      EXPECT_FALSE(filter.update().failed);
      update += heap_count().allocations - between;
      propagate += between - start;
    }
    return std::pair(propagate, update);
  };
  frames(20);
  const long live = heap_count().live_bytes;
  const auto [propagate, update] = frames(100);
  EXPECT_EQ(heap_count().live_bytes, live);
  const auto [propagate_later, update_later] = frames(100);
  EXPECT_EQ(heap_count().live_bytes, live);
  EXPECT_EQ(propagate, propagate_later);
  EXPECT_EQ(update, update_later);
  RecordProperty("allocations_per_propagation", static_cast<int>(propagate / 100));
  RecordProperty("allocations_per_update", static_cast<int>(update / 100));
  EXPECT_LE(propagate, 100 * kPropagationLimit);
  EXPECT_LE(update, 100 * kUpdateLimit);
}

/// Round the hallway's block for ten minutes, 10 frames a second.
Recording ten_minutes() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.sections = 36;
  scene.settings.frame_rate = 10;
  return simulate_inertial(scene);
}

struct Passed {
  double minutes = 0;
  long live_bytes = 0, landmarks = 0;
};

// Of the frames' own estimates nothing is kept: a user who wants them stores them.
std::vector<Passed> minute_by_minute(const Recording& recording) {
  InertialSlamSettings settings;
  InertialSession session(settings, {},
                          {.cameras = recording.cameras, .noise = *recording.imu_noise, .imu = {}},
                          draw_start(recording, settings, 0, 0));
  std::vector<Passed> passed;
  EventStream stream(recording);
  const Time begin = recording.frames.front().time;
  while (auto event = stream.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) session.process(*sample);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    const auto estimates = session.process(*frame);
    const double minutes = to_seconds(frame->time - begin) / 60;
    if (estimates.empty() || minutes < 1 + static_cast<double>(passed.size())) continue;
    passed.push_back({.minutes = minutes,
                      .live_bytes = heap_count().live_bytes,
                      .landmarks = estimates.back().landmarks});
  }
  EXPECT_EQ(session.resets(), 0);
  return passed;
}

// The map alone may grow, by its landmarks; what holds them may have room for twice as many. What
// is in the state, and waits to be, comes and goes.
TEST(Heap, OverTenMinutesGrowsByTheMapAlone) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  constexpr long kRoom = 200'000;
  const std::vector<Passed> passed = minute_by_minute(ten_minutes());
  ASSERT_GE(passed.size(), 10u);
  const Passed &early = passed[1], &late = passed.back();
  EXPECT_GT(late.landmarks, 2 * early.landmarks);
  const long map = 2 * late.landmarks * static_cast<long>(sizeof(MapLandmark));
  EXPECT_LT(late.live_bytes - early.live_bytes, map + kRoom);
  RecordProperty("landmarks", static_cast<int>(late.landmarks));
  RecordProperty("live_bytes", static_cast<int>(late.live_bytes));
  RecordProperty("grown_bytes", static_cast<int>(late.live_bytes - early.live_bytes));
  RecordProperty("bytes_a_landmark", static_cast<int>((late.live_bytes - early.live_bytes) /
                                                      (late.landmarks - early.landmarks)));
}

}  // namespace
}  // namespace chasles::test
