#include <map>
#include <memory>
#include <set>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/slam/closure_trial.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Landmarks that return by their ids, right and wrong ones, twice round a block.
namespace chasles {
namespace {

using test::Estimates;
using test::position_sigma;

Recording twice_round(const InertialScene& changed, std::uint64_t run = 0) {
  InertialScene scene = changed;
  scene.settings.sections = 8;
  scene.settings.keep_ids = true;
  return simulate_inertial(scene, run);
}

InertialScene small_block() {
  InertialScene scene = test::short_hallway();
  scene.settings.frame_rate = 14;
  return scene;
}

// In the second half, landmarks that return bear the ids of others that do.
Recording with_wrong_returns(Recording recording) {
  const Time middle = (recording.frames.front().time + recording.frames.back().time) / 2;
  std::set<LandmarkId> first, both;
  for (const FeatureFrame& frame : recording.frames) {
    for (const PixelObservation& o : frame.pixels) {
      if (frame.time < middle) {
        first.insert(o.landmark);
      } else if (first.contains(o.landmark)) {
        both.insert(o.landmark);
      }
    }
  }
  const std::vector<LandmarkId> ids(both.begin(), both.end());
  std::map<LandmarkId, LandmarkId> other;
  for (std::size_t i = 0; i < ids.size(); ++i) other[ids[i]] = ids[(i + 1) % ids.size()];
  for (FeatureFrame& frame : recording.frames) {
    if (frame.time < middle) continue;
    for (PixelObservation& o : frame.pixels) {
      if (const auto known = other.find(o.landmark); known != other.end()) {
        o.landmark = known->second;
      }
    }
  }
  return recording;
}

struct Result {
  Estimates estimates;
  int undone = 0;
};

Result run(const Recording& recording, Recognise recognise, bool on_trial) {
  InertialSlamSettings settings;
  settings.recognise = recognise;
  auto slam = std::make_unique<InertialSlam>(
      settings, recording.cameras, *recording.imu_noise,
      ImuBuffer::Options{.convention = recording.imu_convention},
      recording.single_pixel_sigma.value_or(1), draw_start(recording, settings, 1, 0));
  ClosureTrial trial;
  Result result;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      slam->process(*sample);
      trial.process(*sample);
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    Estimate e = slam->process(*frame);
    if (on_trial) {
      if (const auto without = trial.assess(*frame, slam)) {
        EXPECT_EQ(without->time, e.time);
        e = *without;
        ++result.undone;
      }
    }
    result.estimates.push_back(e);
  }
  return result;
}

// A filter that is tried is the same filter, as long as nothing contradicts it.
TEST(ClosureTrial, LeavesRightReturnsAlone) {
  const Recording recording = twice_round(small_block());
  const Result alone = run(recording, Recognise::kIds, false);
  const Result tried = run(recording, Recognise::kIds, true);
  EXPECT_EQ(tried.undone, 0);
  ASSERT_EQ(alone.estimates.size(), tried.estimates.size());
  EXPECT_EQ(alone.estimates.back().world_T_imu.p, tried.estimates.back().world_T_imu.p);
  EXPECT_EQ(alone.estimates.back().covariance, tried.estimates.back().covariance);
  const Result without = run(recording, Recognise::kNone, false);
  EXPECT_LT(position_sigma(tried.estimates.back()), 0.7 * position_sigma(without.estimates.back()));
}

double position_nees(const Estimates& estimates, const Recording& recording) {
  double sum = 0;
  for (const Estimate& estimate : estimates) {
    const Eigen::Vector3d e = pose_at(recording.truth, estimate.time)->p - estimate.world_T_imu.p;
    sum += e.dot(estimate.covariance.block<3, 3>(3, 3).ldlt().solve(e)) / 3;
  }
  return sum / static_cast<double>(estimates.size());
}

// A wrong return that the gate lets through makes the filter overconfident, which the trial undoes.
// The error of one path may go either way: in 12 runs that of the trial was 1.2 times that of the
// filter alone.
TEST(ClosureTrial, UndoesWrongReturns) {
  double tried_nees = 0, untried_nees = 0, tried_error = 0, error_without = 0;
  for (const std::uint64_t run_number : {0, 1, 2, 3}) {
    const Recording recording = with_wrong_returns(twice_round(small_block(), run_number));
    const Result tried = run(recording, Recognise::kIds, true);
    EXPECT_GT(tried.undone, 3);
    test::expect_sound(tried.estimates);
    tried_nees += position_nees(tried.estimates, recording);
    tried_error += test::error_from(tried.estimates, recording);
    untried_nees += position_nees(run(recording, Recognise::kIds, false).estimates, recording);
    error_without += test::error_from(run(recording, Recognise::kNone, false).estimates, recording);
  }
  EXPECT_LT(tried_nees, 0.85 * untried_nees);
  // It differs from a filter without returns: it does not initialise the landmarks that are to
  // return.
  EXPECT_LT(tried_error, 2 * error_without);
}

// Coarse sensors, and a block of 180 m: the way is wrong by metres when it closes. One
// linearisation bears no such correction; the NEES per degree of freedom was 10 with it.
TEST(ClosureTrial, ALargeCorrectionIsRelinearised) {
  InertialScene scene = inertial_scene("hallway");
  InertialSettings& s = scene.settings;
  s.hall_length = 60;
  s.hall_width = 30;
  s.gyroscope_noise_density = 3e-3;
  s.accelerometer_noise_density = 0.05;
  s.landmarks_in_view = 20;
  s.frame_rate = 10;
  s.sections = 6;
  s.keep_ids = true;
  const Recording recording = simulate_inertial(scene, 0);
  InertialSlamSettings settings;
  settings.recognise = Recognise::kIds;
  settings.exact_map = Toggle::kTrue;
  InertialSession session =
      test::session_for(recording, draw_start(recording, settings, 1, 0), settings);
  test::play(session, recording);
  double nees = 0;
  const std::vector<PastPose> poses = session.past_nav().poses;
  ASSERT_GT(poses.size(), 2000u);
  for (const PastPose& pose : poses) {
    const Eigen::Vector3d e = pose_at(recording.truth, pose.time)->p - pose.map_T_imu.p;
    nees += e.dot(pose.covariance.bottomRightCorner<3, 3>().ldlt().solve(e)) / 3;
  }
  EXPECT_LT(nees / static_cast<double>(poses.size()), 4);
}

}  // namespace
}  // namespace chasles
