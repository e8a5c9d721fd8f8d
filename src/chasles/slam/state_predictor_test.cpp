#include <chrono>
#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/lie/trajectory.hpp>
#include <chasles/slam/inertial_session_testing.hpp>
#include <chasles/slam/state_predictor.hpp>

namespace chasles {
namespace {

using test::Estimates;
using test::session_for;

const Recording& hallway() {
  static const Recording recording = simulate_inertial(test::short_hallway(), 0);
  return recording;
}

StatePredictor predictor_for(const Recording& recording) {
  return {*recording.imu_noise, {.convention = recording.imu_convention}};
}

// Plays until the k-th estimate; returns it, and the time of the frame after it.
Estimate play_until(InertialSession& session, StatePredictor& predictor, std::size_t k,
                    Time& next) {
  EventStream events(hallway());
  Estimates all;
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      append(session.process(*sample), all);
      predictor.add(*sample);
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    next = frame->time;
    if (all.size() > k) return all.back();
    append(session.process(*frame), all);
  }
  ADD_FAILURE() << "fewer estimates";
  return {};
}

// A frame in which nothing is seen is a prediction: that of the filter, in another implementation
// of the chain of steps.
TEST(StatePredictor, IsThePredictionOfTheFilter) {
  InertialSlamSettings settings;
  settings.zupt_velocity_sigma = 0;
  for (const char* chart : {"standard", "right-sen3"}) {
    settings.chart = chart;
    InertialSession session = session_for(hallway(), std::nullopt, settings);
    StatePredictor predictor = predictor_for(hallway());
    Time next{};
    const Estimate last = play_until(session, predictor, 60, next);
    ASSERT_GT(next, last.time);
    predictor.correct(last);
    const auto predicted = predictor.at(next);
    ASSERT_TRUE(predicted);
    EXPECT_EQ(predicted->since_estimate, next - last.time);
    const Estimates expected = session.process(FeatureFrame{.time = next, .pixels = {}});
    ASSERT_EQ(expected.size(), 1u);
    const Estimate& e = expected.front();
    EXPECT_LT((predicted->state.world_T_imu.p - e.world_T_imu.p).norm(), 1e-12);
    EXPECT_LT((predicted->state.world_T_imu.R - e.world_T_imu.R).norm(), 1e-12);
    EXPECT_LT((predicted->state.v_world - *e.v_world).norm(), 1e-12);
    EXPECT_LT((predicted->state.biases() - e.additive).norm(), 1e-15);
    EXPECT_LT((predicted->covariance - e.covariance).norm(), 1e-10 * e.covariance.norm()) << chart;
    // It is no copy of the estimate before.
    EXPECT_GT((predicted->state.world_T_imu.p - last.world_T_imu.p).norm(), 1e-2);
    EXPECT_GT((predicted->covariance - last.covariance).norm(), 1e-4 * e.covariance.norm());
  }
}

// The order in which samples and estimate come changes nothing.
TEST(StatePredictor, ALateEstimateBeginsAnewAtItsOwnTime) {
  InertialSession session = session_for(hallway());
  StatePredictor before = predictor_for(hallway());
  Time next{};
  const Estimate last = play_until(session, before, 40, next);
  StatePredictor after = before;
  before.correct(last);
  for (const ImuSample& sample : hallway().imu) {
    if (sample.time <= next || sample.time > next + std::chrono::milliseconds(150)) continue;
    before.add(sample);
    after.add(sample);
  }
  after.correct(last);
  for (const int ms : {0, 3, 40, 99, 151, 180}) {
    const Time time = next + std::chrono::milliseconds(ms);
    const auto a = before.at(time), b = after.at(time);
    ASSERT_TRUE(a && b) << ms;
    EXPECT_LT((a->state.world_T_imu.p - b->state.world_T_imu.p).norm(), 1e-12) << ms;
    EXPECT_LT((a->covariance - b->covariance).norm(), 1e-12) << ms;
  }
}

TEST(StatePredictor, OnDemandIsTheSameState) {
  InertialSession session = session_for(hallway());
  StatePredictor at_once = predictor_for(hallway());
  Time next{};
  const Estimate last = play_until(session, at_once, 40, next);
  StatePredictor on_demand = at_once.with(StatePredictor::Work::kOnDemand);
  at_once.correct(last);
  on_demand.correct(last);
  for (const ImuSample& sample : hallway().imu) {
    if (sample.time <= next || sample.time > next + std::chrono::milliseconds(150)) continue;
    at_once.add(sample);
    on_demand.add(sample);
  }
  for (const int ms : {-20, 0, 3, 99, 151, 180}) {
    const Time time = next + std::chrono::milliseconds(ms);
    const auto a = at_once.at(time), b = on_demand.at(time);
    ASSERT_TRUE(a && b) << ms;
    EXPECT_EQ(a->state.world_T_imu.p, b->state.world_T_imu.p) << ms;
    EXPECT_EQ(a->covariance, b->covariance) << ms;
    EXPECT_EQ(a->angular_rate_imu, b->angular_rate_imu) << ms;
  }
  // Also the end of the prediction.
  const Time end = last.time + StatePredictor::kLongest + std::chrono::milliseconds(1);
  for (Time t = next + std::chrono::milliseconds(155); t < end; t += std::chrono::milliseconds(5)) {
    ImuSample sample = hallway().imu.front();
    sample.time = t;
    sample.angular_rate_imu.x() += 1e-3 * static_cast<double>((t / Time(5'000'000)) % 7);
    at_once.add(sample);
    on_demand.add(sample);
  }
  EXPECT_FALSE(at_once.at(next));
  EXPECT_FALSE(on_demand.at(next));
}

// The errors at all times between frames against the truth, by their own sigmas.
TEST(StatePredictor, IsAsWrongAsItSaysAtTheRateOfTheImu) {
  InertialSession session = session_for(hallway());
  StatePredictor predictor = predictor_for(hallway());
  EventStream events(hallway());
  double nees = 0;
  int count = 0, none = 0;
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      const Estimates waited = session.process(*sample);
      predictor.add(*sample);
      for (const Estimate& e : waited) predictor.correct(e);
      const auto now = predictor.at(sample->time);
      const auto truth = pose_at(hallway().truth, sample->time, std::chrono::milliseconds(40));
      none += !now;
      if (!now || !truth) continue;
      // Position and heading are relative to the start: tilt alone is absolute.
      const Eigen::Vector3d up =
          now->state.world_T_imu.R * truth->R.transpose() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector2d tilt(up.y(), -up.x());
      nees += tilt.dot(now->covariance.topLeftCorner<2, 2>().inverse() * tilt);
      ++count;
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    for (const Estimate& e : session.process(*frame)) predictor.correct(e);
  }
  ASSERT_GT(count, 500);
  EXPECT_LT(none, count);
  // One run: its errors are correlated in time.
  EXPECT_GT(nees / count, 0.02);
  EXPECT_LT(nees / count, 8);
}

TEST(StatePredictor, HasNoneBeforeAnEstimateOrWhereSamplesAreMissing) {
  StatePredictor predictor = predictor_for(hallway());
  const Time t = std::chrono::seconds(10);
  EXPECT_FALSE(predictor.at(t));
  ImuSample sample{.time = t, .specific_force_imu = {0.1, 0, 9.8}, .angular_rate_imu = {0, 0.1, 0}};
  predictor.add(sample);
  EXPECT_FALSE(predictor.at(t));
  Estimate e;
  e.time = t;
  predictor.correct(e);  // without a velocity
  EXPECT_FALSE(predictor.at(t));
  e.v_world = Eigen::Vector3d(1, 0, 0);
  e.additive = Vector6d::Zero();
  e.covariance = Matrix15d::Identity();
  predictor.correct(e);
  EXPECT_FALSE(predictor.at(t - Time(1)));
  ASSERT_TRUE(predictor.at(t));
  EXPECT_EQ(predictor.at(t)->state.world_T_imu.p, Eigen::Vector3d::Zero());
  // The last sample is held, for as long as a gap is bridged.
  const auto later = predictor.at(t + std::chrono::milliseconds(100));
  ASSERT_TRUE(later);
  EXPECT_NEAR(later->state.world_T_imu.p.x(), 0.1, 0.02);
  EXPECT_NEAR(later->angular_rate_imu.y(), 0.1, 1e-12);
  EXPECT_FALSE(predictor.at(t + TimeGaps::kLongest + Time(1)));
}

constexpr Time kStart = std::chrono::seconds(10);

ImuSample sample_at(Time time) {
  const double phase = to_seconds(time);  // a sensor that never changes is frozen
  return {.time = time, .specific_force_imu = {0.1 * std::sin(phase), 0, 9.8}};
}

void add_samples(StatePredictor& predictor, Time from, Time to) {
  for (Time t = from; t <= to; t += std::chrono::milliseconds(5)) predictor.add(sample_at(t));
}

Estimate estimate_at(Time time) {
  Estimate e;
  e.time = time;
  e.v_world = Eigen::Vector3d(1, 0, 0);
  e.additive = Vector6d::Zero();
  e.covariance = Matrix15d::Identity();
  return e;
}

// Images have ended: nobody should fly on by the samples alone for minutes.
TEST(StatePredictor, EndsOnceTheEstimateIsTooOld) {
  StatePredictor predictor = predictor_for(hallway());
  add_samples(predictor, kStart, kStart);
  predictor.correct(estimate_at(kStart));
  const Time limit = kStart + StatePredictor::kLongest;
  add_samples(predictor, kStart + std::chrono::milliseconds(5), limit);
  EXPECT_TRUE(predictor.at(limit));
  EXPECT_FALSE(predictor.at(limit + Time(1)));
  const Time later = kStart + std::chrono::minutes(10);
  add_samples(predictor, limit + std::chrono::milliseconds(5), later);
  EXPECT_FALSE(predictor.at(later));
  EXPECT_FALSE(predictor.at(limit));
  // Late estimates: one that is too old already, and one that is not.
  predictor.correct(estimate_at(later - StatePredictor::kLongest - Time(1)));
  EXPECT_FALSE(predictor.at(later));
  predictor.correct(estimate_at(later - std::chrono::seconds(4)));
  ASSERT_TRUE(predictor.at(later));
  EXPECT_EQ(predictor.at(later)->since_estimate, std::chrono::seconds(4));
}

TEST(StatePredictor, EndsWhereTheEstimateIsLost) {
  StatePredictor predictor = predictor_for(hallway());
  add_samples(predictor, kStart, kStart);
  predictor.correct(estimate_at(kStart));
  EXPECT_TRUE(predictor.at(kStart));
  Estimate lost = estimate_at(kStart);
  lost.health = Health::kLost;
  predictor.correct(lost);
  EXPECT_FALSE(predictor.at(kStart));
}

// After it the motion is unknown; a late estimate from before it is no way across.
TEST(StatePredictor, EndsAtAGapBetweenSamples) {
  StatePredictor predictor = predictor_for(hallway());
  add_samples(predictor, kStart, kStart + std::chrono::milliseconds(100));
  predictor.correct(estimate_at(kStart));
  const Time bridged = kStart + std::chrono::milliseconds(550);
  add_samples(predictor, bridged, bridged + std::chrono::milliseconds(10));
  EXPECT_TRUE(predictor.at(bridged));
  const Time after = bridged + std::chrono::milliseconds(600);
  add_samples(predictor, after, after + std::chrono::milliseconds(50));
  EXPECT_FALSE(predictor.at(after));
  predictor.correct(estimate_at(bridged));
  EXPECT_FALSE(predictor.at(after));
  predictor.correct(estimate_at(after + std::chrono::milliseconds(20)));
  EXPECT_TRUE(predictor.at(after + std::chrono::milliseconds(50)));
}

}  // namespace
}  // namespace chasles
