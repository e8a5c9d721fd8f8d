#include <array>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/ekf.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/velocity/body_velocity_model.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

#include "heap_count.hpp"

// Heap use of a run, per frame and over ten minutes.
namespace chasles::test {
namespace {

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

/// 50 landmarks in the state, observed repeatedly by a static camera.
class Standing {
 public:
  Standing() : filter_(error_chart("right-sen3"), initial(), covariance(), options()) {
    noise_.walk.setConstant(0.1);
    noise_.sample_sigma.setConstant(0.1);
    std::vector<NewLandmark> landmarks;
    for (LandmarkId id = 0; id < 50; ++id) {
      landmarks.push_back(*initialise_landmark(rig_, kPixels, filter_.state(), observe(id)));
    }
    filter_.add(landmarks);
    for (int i = 0; i < 50; ++i) {
      const auto id = static_cast<LandmarkId>(i);
      measurements_.push_back(
          *measure_stereo(rig_, StereoRows::kMean, kPixels, filter_.state(), i, observe(id)));
    }
  }
  Prediction predicted() const { return predict(model_, filter_.state(), {}, 0.05, noise_); }
  void propagate(const Prediction& prediction) { filter_.propagate(prediction); }
  bool update() { return !filter_.update(measurements_).failed; }

 private:
  static constexpr StereoNoise kPixels{.u = 1, .v = 1, .disparity = 0.5};
  static Ekf::Options options() { return {.map = Ekf::Map::kFrozen}; }
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

/// Heap calls by operation.
template <class Function>
long allocations_of(const Function& function) {
  const long before = heap_count().allocations;
  function();
  return heap_count().allocations - before;
}

TEST(Heap, AFilterOfAConstantStateAsksForNothing) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  Standing filter;
  long propagate = 0, update = 0, live = 0;
  for (int i = 0; i < 200; ++i) {
    if (i == 5) live = heap_count().live_bytes;
    const Prediction prediction = filter.predicted();
    const long one = allocations_of([&] { filter.propagate(prediction); });
    bool well = false;
    const long other = allocations_of([&] { well = filter.update(); });
    EXPECT_TRUE(well);
    if (i < 5) continue;
    propagate += one;
    update += other;
  }
  EXPECT_EQ(propagate, 0);
  EXPECT_EQ(update, 0);
  EXPECT_LE(heap_count().live_bytes, live);
}

/// An inertial filter with 50 landmarks, half of them anchored, and 6 clones, in any chart.
class Inertial {
 public:
  explicit Inertial(const ErrorChart& chart)
      : filter_(chart, initial(), 0.01 * Eigen::MatrixXd::Identity(15, 15),
                {.map = Ekf::Map::kFrozen}) {
    filter_.clone_pose(clone_++, Time{});
    for (LandmarkId id = 0; id < 50; ++id) filter_.add(std::array{initialised(id)});
    for (int i = 0; i < 5; ++i) filter_.clone_pose(clone_++, Time{});
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d pixel = observe(static_cast<LandmarkId>(i)).pixels.head<2>();
      measurements_.push_back(*measure_pixel(camera_, 1, filter_.state(), i, pixel));
      measurements_.back().gate = 100;
    }
    fresh_ = initialised(50);
  }
  void predict_and_propagate() {
    predict(model_, filter_.state(), {}, prediction_);
    prediction_.Q.diagonal().setConstant(1e-4);
    filter_.propagate(prediction_);
  }
  void update() {
    const UpdateReport& report = filter_.update(measurements_);
    EXPECT_FALSE(report.failed);
    EXPECT_EQ(report.dof, 100);
  }
  void read() const {
    EXPECT_GE(filter_.normalised_square(measurements_[1]), 0);
    EXPECT_LT(filter_.joint_normalised_square(measurements_), 1000);
  }
  void exchange_clones() {
    filter_.clone_pose(clone_++, Time{});
    filter_.remove_clones(std::array{clone_ - 6});
  }
  void exchange_landmarks() {
    filter_.add({&fresh_, 1});
    filter_.retire(std::array{50});
  }

 private:
  static State initial() {
    State x;
    x.v_world = Eigen::Vector3d::Zero();
    x.additive = Eigen::VectorXd::Zero(InertialModel::kSize);
    return x;
  }
  NewLandmark initialised(LandmarkId id) const {
    const Eigen::Vector2d pixel = observe(id).pixels.head<2>();
    return id % 2 == 0 ? *initialise_at_depth(camera_, 1, filter_.state(), id, pixel, 10, 2)
                       : *initialise_anchored(camera_, 1, filter_.state(), id, pixel, 0.1, 0.02);
  }

  InertialModel model_;
  Camera camera_{.width = 1200,
                 .height = 360,
                 .fx = 700,
                 .fy = 700,
                 .cx = 600,
                 .cy = 180,
                 .cam_T_imu = rig().cam0_T_imu};
  Ekf filter_;
  Prediction prediction_;
  std::vector<Measurement> measurements_;
  NewLandmark fresh_;
  int clone_ = 0;
};

TEST(Heap, AnInertialFilterWithClonesAsksForNothingInAnyChart) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  for (const ErrorChart& chart : error_charts()) {
    SCOPED_TRACE(chart.name);
    Inertial filter(chart);
    long propagate = 0, update = 0, read = 0, clones = 0, landmarks = 0;
    for (int i = 0; i < 100; ++i) {
      if (i == 5) propagate = update = read = clones = landmarks = 0;
      propagate += allocations_of([&] { filter.predict_and_propagate(); });
      update += allocations_of([&] { filter.update(); });
      read += allocations_of([&] { filter.read(); });
      clones += allocations_of([&] { filter.exchange_clones(); });
      landmarks += allocations_of([&] { filter.exchange_landmarks(); });
    }
    EXPECT_EQ(propagate, 0);
    EXPECT_EQ(update, 0);
    EXPECT_EQ(read, 0);
    EXPECT_EQ(clones, 0);
    // The map of 5 … 100 landmarks, which doubles its capacity.
    EXPECT_LE(landmarks, 5);
  }
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

// The run keeps no estimates of single frames; the caller stores them if needed.
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

// Only the map may grow, by its landmarks; its container may have twice the capacity. Landmarks in
// the state, and those that wait for initialisation, come and go.
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

/// Calls in the frames after the warm-up.
struct Asked {
  long frames = 0, quiet_frames = 0;  ///< quiet: no landmark was initialised or retired
  long calls = 0, quiet_calls = 0;
};

Asked asked_in(const char* scene, double warm_up) {
  const Recording recording = simulate_inertial(inertial_scene(scene));
  const InertialSlamSettings settings;
  InertialSlam slam(settings, recording.cameras, *recording.imu_noise, {}, 1,
                    draw_start(recording, settings, 0, 0));
  EventStream stream(recording);
  Asked asked;
  int in_state = 0;
  const Time begin = recording.frames.front().time;
  while (auto event = stream.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    Estimate e;
    const long calls = allocations_of([&] { e = slam.process(*frame); });
    const bool quiet = e.added == 0 && e.in_state == in_state;
    in_state = e.in_state;
    if (to_seconds(frame->time - begin) < warm_up) continue;
    ++asked.frames;
    asked.calls += calls;
    if (!quiet) continue;
    ++asked.quiet_frames;
    asked.quiet_calls += calls;
  }
  return asked;
}

// Tracks begin, end and are tested in quiet frames as well. Retired landmarks extend the map, whose
// vector sometimes doubles its capacity; a list that is longer than ever before allocates.
TEST(Heap, AFrameAsksForNothingOnceItsListsHaveTheirRoom) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  const Asked asked = asked_in("hallway", 30);
  RecordProperty("frames", static_cast<int>(asked.frames));
  RecordProperty("calls", static_cast<int>(asked.calls));
  ASSERT_GT(asked.quiet_frames, 500);
  ASSERT_GT(asked.frames, asked.quiet_frames + 300);
  EXPECT_EQ(asked.quiet_calls, 0);
  EXPECT_LE(asked.calls, 20);
}

}  // namespace
}  // namespace chasles::test
