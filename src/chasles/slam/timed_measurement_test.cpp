#include <algorithm>
#include <cmath>
#include <functional>

#include <chasles/eval/chi2.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// A barometer as a sensor that the filter does not know: the height above the start.
namespace chasles {
namespace {

using namespace test;

constexpr double kHeightSigma = 0.005;  // [m]

TimedMeasurement height(Time time, double z, double sigma = kHeightSigma) {
  return {.time = time, .model = [z, sigma](const State& x) {
            Measurement m;
            m.core_column = 5;  // z of the position
            m.residual = Eigen::Matrix<double, 1, 1>(z - x.world_T_imu.p.z());
            m.d_core = Eigen::Matrix<double, 1, 1>(1);
            m.noise = Eigen::Matrix<double, 1, 1>(sigma * sigma);
            return m;
          }};
}

struct Estimation {
  std::vector<Estimate> estimates;
  TimedMeasurementCounts counts;
};

/// The walk with what `at` has for each IMU sample's time; none: no measurement.
Estimation walk(const Recording& recording, const InertialStart& start,
                const std::function<std::optional<TimedMeasurement>(Time)>& at,
                const InertialSlamSettings& settings = {}) {
  InertialSlam slam(settings, recording.cameras, *recording.imu_noise,
                    {.convention = recording.imu_convention}, 1, start);
  Estimation run;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      slam.process(*sample);
      if (const auto measurement = at(sample->time)) slam.process(*measurement);
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (frame && frame->time >= start.time) run.estimates.push_back(slam.process(*frame));
  }
  run.counts = slam.propagator().timed_counts();
  return run;
}

double height_error(const Recording& recording, const Estimate& e) {
  return e.world_T_imu.p.z() - pose_at(recording.truth, e.time)->p.z();
}

TEST(TimedMeasurement, OfTheHeightMakesItMoreAccurateAndKeepsTheFilterConsistent) {
  double with = 0, without = 0, nees = 0;
  int rejected = 0;
  constexpr int kRuns = 10;
  for (std::uint64_t k = 0; k < kRuns; ++k) {
    const Recording recording = simulate_inertial(short_hallway(), k);
    const InertialStart start = draw_start(recording, {}, 1, k);
    const chasles::Random random = random_of_run(2, k);
    std::uint64_t number = 0;
    const auto barometer = [&](Time time) -> std::optional<TimedMeasurement> {
      const auto truth = pose_at(recording.truth, time);
      if (++number % 10 != 0 || !truth || time < start.time) return std::nullopt;
      return height(
          time, truth->p.z() + kHeightSigma * random.normal(Stream::kAccelerometerNoise, number));
    };
    const Estimation run = walk(recording, start, barometer);
    const Estimation plain = walk(recording, start, [](Time) { return std::nullopt; });
    EXPECT_GT(run.counts.used, 150);
    rejected += run.counts.rejected;
    EXPECT_EQ(run.counts.late, 0);
    const Estimate& last = run.estimates.back();
    const double error = height_error(recording, last);
    EXPECT_LT(last.covariance(5, 5), plain.estimates.back().covariance(5, 5));
    nees += error * error / last.covariance(5, 5);
    with += error * error;
    without += std::pow(height_error(recording, plain.estimates.back()), 2);
  }
  EXPECT_LT(with, 0.5 * without);
  EXPECT_LT(rejected, 8);  // the gate rejects 0.1 % of 1600, more than 7 with a probability of 3e-4
  const Band band = chi2_band(1, kRuns, 0.999);
  EXPECT_GT(nees / kRuns, band.low);
  EXPECT_LT(nees / kRuns, band.high);
}

// Between two frames of a walk at 1 m/s and more: the state is that of the time between them.
TEST(TimedMeasurement, CountsAtItsOwnTime) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  const InertialStart start = draw_start(recording, {}, 1, 0);
  constexpr std::size_t kFrame = 150;
  const Time before = recording.frames[kFrame].time, behind = recording.frames[kFrame + 1].time;
  const Time between = before + (behind - before) / 4;
  std::optional<Eigen::Vector3d> p_between;
  bool given = false;
  const Estimation run = walk(recording, start, [&](Time time) -> std::optional<TimedMeasurement> {
    if (given || time < between) return std::nullopt;
    given = true;
    TimedMeasurement measurement = height(between, 0, 100);  // of no weight
    measurement.model = [&, model = measurement.model](const State& x) {
      p_between = x.world_T_imu.p;
      return model(x);
    };
    return measurement;
  });
  ASSERT_TRUE(p_between);
  const auto at = [&](Time time) {
    return std::ranges::find(run.estimates, time, &Estimate::time)->world_T_imu.p;
  };
  const double step = (at(behind) - at(before)).norm();
  ASSERT_GT(step, 0.02);
  EXPECT_LT((*p_between - (0.75 * at(before) + 0.25 * at(behind))).norm(), 0.1 * step);
}

TEST(TimedMeasurement, ThatIsWrongOrLateIsCountedAndChangesNothing) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  const InertialStart start = draw_start(recording, {}, 1, 0);
  const Estimation plain = walk(recording, start, [](Time) { return std::nullopt; });
  int given = 0;
  const Estimation spoilt =
      walk(recording, start, [&](Time time) -> std::optional<TimedMeasurement> {
        if (time < after(recording, 1) || given == 3) return std::nullopt;
        switch (given++) {
          case 0:
            return height(start.time - from_seconds(1), 0);  // late
          case 1:
            return height(recording.frames[50].time, 100);  // wrong, at a frame's own time
          default:
            return height(recording.frames[50].time, std::nan(""));
        }
      });
  EXPECT_EQ(spoilt.counts.late, 1);
  EXPECT_EQ(spoilt.counts.rejected, 2);
  EXPECT_EQ(spoilt.counts.used, 0);
  ASSERT_EQ(spoilt.estimates.size(), plain.estimates.size());
  EXPECT_LT((spoilt.estimates.back().world_T_imu.p - plain.estimates.back().world_T_imu.p).norm(),
            1e-9);
}

// The state is then that of an image, so several of them apply at one frame.
TEST(TimedMeasurement, AppliesAtTheNextFrameWhereTheTimeOffsetIsEstimated) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  const InertialStart start = draw_start(recording, {}, 1, 0);
  InertialSlamSettings settings;
  settings.calibrate_time_offset = Calibrate::kTrue;
  int given = 0;
  const Estimation run = walk(
      recording, start,
      [&](Time time) -> std::optional<TimedMeasurement> {
        const auto truth = pose_at(recording.truth, time);
        if (!truth || time < after(recording, 1)) return std::nullopt;
        ++given;
        return height(time, truth->p.z(), 0.2);
      },
      settings);
  EXPECT_EQ(run.counts.late, 0);
  EXPECT_GT(run.counts.used, given * 9 / 10);
  EXPECT_LT(std::abs(height_error(recording, run.estimates.back())), 0.05);
}

TEST(TimedMeasurement, WaitsForTheStartOfASession) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  InertialSession session = session_for(recording);
  EventStream events(recording);
  std::vector<Time> given;
  std::optional<Time> started;
  std::size_t number = 0;
  const auto note = [&](const std::vector<Estimate>& estimates) {
    if (!started && !estimates.empty()) started = estimates.front().time;
  };
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      note(session.process(*sample));
      if (number++ % 10 == 0) {
        given.push_back(sample->time);
        session.process({.time = sample->time, .model = [](const State& x) {
                           return height(Time{}, x.world_T_imu.p.z()).model(x);
                         }});
      }
    }
    if (const auto* frame = std::get_if<FeatureFrame>(&*event)) note(session.process(*frame));
  }
  ASSERT_TRUE(started);
  const auto before = std::ranges::count_if(given, [&](Time time) { return time < *started; });
  const auto behind =
      std::ranges::count_if(given, [&](Time time) { return time > recording.frames.back().time; });
  const TimedMeasurementCounts counts = session.report().timed;
  EXPECT_EQ(counts.late, before);
  EXPECT_EQ(counts.used, std::ssize(given) - before - behind);
  EXPECT_GT(counts.used, 150);
  EXPECT_EQ(counts.rejected, 0);
}

}  // namespace
}  // namespace chasles
