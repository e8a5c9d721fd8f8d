#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/slam/calibration_testing.hpp>

// Estimation of extrinsics and time offset on simulated recordings with known calibration.

namespace chasles {
namespace {

using namespace test;

// Sums over runs.
struct Sums {
  double calibration = 0, pose = 0;
  int dof = 0, poses = 0;

  void add(const Miscalibrated& m, const InertialSlamSettings& settings) {
    const Trial trial = run_trial({.name = "", .settings = settings}, m.recording, m.start);
    ASSERT_FALSE(trial.diverged);
    ASSERT_TRUE(trial.calibration);
    const Eigen::VectorXd error = calibration_error(m.truth, *trial.calibration);
    calibration += normalised_square(error, trial.calibration->covariance);
    dof += static_cast<int>(error.size());
    for (const TrialPoint& point : trial.points) {
      if (std::isnan(point.nees_pose)) continue;
      pose += point.nees_pose / 6;
      ++poses;
    }
  }
  double pose_nees() const { return pose / poses; }
};

// A rig whose cameras have small relative errors: 0.3 degrees and 5 mm.
InertialSlamSettings calibrating_a_rig() {
  InertialSlamSettings settings = calibrating();
  settings.initial_extrinsic_rotation_sigma = 0.005;
  settings.initial_extrinsic_translation_sigma = 0.005;
  return settings;
}

TEST(Calibrating, IsWrongByAsMuchAsItSays) {
  for (const int cameras : {1, 2}) {
    const InertialSlamSettings settings = cameras == 1 ? calibrating() : calibrating_a_rig();
    Sums s;
    for (std::uint64_t run = 0; run < (cameras == 1 ? 20 : 10); ++run) {
      s.add(drawn(shaken(cameras), settings, run), settings);
    }
    const double dof = s.dof;
    EXPECT_EQ(s.dof, cameras == 1 ? 140 : 130);
    EXPECT_GT(s.calibration, chi2_quantile(0.0005, dof)) << cameras;
    EXPECT_LT(s.calibration, chi2_quantile(0.9995, dof)) << cameras;
    EXPECT_GT(s.pose_nees(), 0.7) << cameras;
    EXPECT_LT(s.pose_nees(), 1.7) << cameras;  // 1.3 and 1.1 without calibration
  }
}

TEST(Calibrating, WhereNothingIsWrongThePoseStaysConsistent) {
  Sums s;
  for (std::uint64_t run = 0; run < 6; ++run) {
    const Recording recording = simulate_densely(shaken(1), run);
    s.add(miscalibrated(recording, Eigen::VectorXd::Zero(7),
                        draw_start(recording, calibrating(), 1, run)),
          calibrating());
  }
  EXPECT_GT(s.pose_nees(), 0.7);
  EXPECT_LT(s.pose_nees(), 1.6);
  EXPECT_LT(s.calibration / s.dof, 1.5);
}

// Five milliseconds that are considered: the covariance holds, and the offset stays.
TEST(Calibrating, AConsideredTimeOffsetIsCountedAndNotCorrected) {
  constexpr int kRuns = 10;
  InertialSlamSettings known, settings;
  settings.calibrate_time_offset = Calibrate::kConsidered;
  double nees = 0, wrong = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate_densely(shaken(1), run);
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(7);
    errors[6] = 0.005 * random_of_run(79, run).normal(Stream::kStart, 1, 0);
    const Miscalibrated m =
        miscalibrated(recording, errors, draw_start(recording, settings, 1, run));
    const Trial trial = run_trial({.name = "", .settings = settings}, m.recording, m.start);
    ASSERT_FALSE(trial.diverged);
    ASSERT_TRUE(trial.calibration);
    EXPECT_EQ(trial.calibration->time_offset, 0);
    EXPECT_NEAR(trial.calibration->covariance(0, 0), 0.005 * 0.005, 1e-12);
    nees += averages(trial).nees_pose / 6 / kRuns;
    const Trial other = run_trial({.name = "", .settings = known}, m.recording, m.start);
    wrong += averages(other).nees_pose / 6 / kRuns;
  }
  EXPECT_LT(nees, 1.7);
  EXPECT_GT(nees, 0.5);
  EXPECT_GT(wrong, 2 * nees);
}

// Two degrees, three centimetres and ten milliseconds.
Miscalibrated by_much(const InertialSlamSettings& settings, double shake = 0.08) {
  InertialScene scene = shaken(1);
  scene.settings.sections = 2;
  auto& s = scene.settings;
  s.roll_amplitude = s.pitch_amplitude = s.yaw_amplitude = shake;
  const Recording recording = simulate_densely(scene, 0);
  Eigen::VectorXd errors(7);
  errors << 0.02, -0.02, 0.02, 0.017, -0.017, 0.017, 0.01;
  return miscalibrated(recording, errors, draw_start(recording, settings, 1, 0));
}

InertialSlamSettings expecting_much() {
  InertialSlamSettings settings = calibrating();
  settings.initial_extrinsic_rotation_sigma = 0.02;
  settings.initial_extrinsic_translation_sigma = 0.02;
  settings.initial_time_offset_sigma = 0.01;
  return settings;
}

void expect_found(const Miscalibrated& m, const Calibration& found, const std::string& how) {
  const Eigen::VectorXd error = calibration_error(m.truth, found);
  const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
  EXPECT_LT(error.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 3.5) << how;
  EXPECT_LT(error.head<3>().norm(), 0.005) << how;
  EXPECT_LT(error.segment<3>(3).norm(), 0.012) << how;
  EXPECT_LT(std::abs(error[6]), 2e-4) << how;
}

TEST(Calibrating, FindsWhatIsWrongInEveryChart) {
  for (const ErrorChart& chart : error_charts()) {
    InertialSlamSettings settings = expecting_much();
    settings.chart = chart.name;
    // The papers' charts with their composition.
    settings.nav_attitude = chart.name != "right-sen3";
    settings.composition_interval = settings.nav_attitude ? 0.5 : 0;
    const Miscalibrated m = by_much(settings);
    const Trial trial = run_trial({.name = "", .settings = settings}, m.recording, m.start);
    ASSERT_TRUE(trial.calibration) << chart.name;
    expect_found(m, *trial.calibration, std::string(chart.name));
    EXPECT_LT(averages(trial).position_error, 0.15) << chart.name;
  }
  InertialSlamSettings without;
  const Miscalibrated m = by_much(without);
  const Trial trial = run_trial({.name = "", .settings = without}, m.recording, m.start);
  EXPECT_TRUE(trial.diverged || averages(trial).position_error > 0.3);
}

TEST(Calibrating, GoesWithFirstEstimatesAndEveryFormAndBeginning) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    InertialSlamSettings settings = expecting_much();
    settings.chart = "standard";
    settings.landmarks = form;
    settings.first_estimates = Toggle::kTrue;
    const Miscalibrated m = by_much(settings);
    const Trial trial = run_trial({.name = "", .settings = settings}, m.recording, m.start);
    ASSERT_TRUE(trial.calibration) << name_of(form);
    expect_found(m, *trial.calibration, "first estimates, " + std::string(name_of(form)));
  }
  InertialSlamSettings settings = expecting_much();
  settings.init = LandmarkInit::kFixedDepth;
  const Miscalibrated m = by_much(settings);
  const Trial trial = run_trial({.name = "", .settings = settings}, m.recording, m.start);
  ASSERT_TRUE(trial.calibration);
  const Eigen::VectorXd error = calibration_error(m.truth, *trial.calibration);
  EXPECT_LT(error.head<3>().norm(), 0.01);  // of 0.035; its depths are assumed
  EXPECT_LT(std::abs(error[6]), 1e-3);
}

// Stamps early by 13 ms, with the offset given: the run equals the one with correct stamps.
TEST(TimeOffset, ThatIsKnownIsAsIfTheStampsWereRight) {
  for (const double offset : {0.013, -0.013}) {
    const Recording right = simulate_densely(shaken(1), 0);
    InertialSlamSettings settings;
    const InertialStart start = draw_start(right, settings, 1, 0);
    Recording early = right;
    for (FeatureFrame& frame : early.frames) frame.time -= from_seconds(offset);
    const Trial expected = run_trial({.name = "", .settings = settings}, right, start);
    settings.time_offset = offset;
    const Trial trial = run_trial({.name = "", .settings = settings}, early, start);
    ASSERT_EQ(trial.estimate.size(), expected.estimate.size());
    for (std::size_t k = 0; k < trial.estimate.size(); ++k) {
      ASSERT_EQ(trial.estimate[k].time, expected.estimate[k].time);
      ASSERT_EQ(trial.estimate[k].pose.p, expected.estimate[k].pose.p);
    }
  }
}

// Frames that are stamped early wait for samples, but not for the next frame.
TEST(TimeOffset, AnEstimateComesWithTheSampleForWhichItsFrameWaits) {
  Recording early = simulate_densely(shaken(1), 0);
  InertialSlamSettings settings;
  settings.time_offset = 0.013;
  const InertialStart start = draw_start(early, settings, 1, 0);
  for (FeatureFrame& frame : early.frames) frame.time -= from_seconds(*settings.time_offset);
  InertialSession session = session_for(early, start, settings);
  bool waiting = false;
  int waited = 0;
  EventStream events(early);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      for (const Estimate& e : session.process(*sample)) {
        EXPECT_GE(sample->time, e.time);
        EXPECT_LT(sample->time - e.time, std::chrono::milliseconds(10));  // of 200 Hz
        waiting = false;
        ++waited;
      }
    }
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    EXPECT_FALSE(waiting && session.running()) << "until the next frame";
    waiting = session.process(*frame).empty();
  }
  EXPECT_GT(waited, 20);
}

TEST(CalibratingSession, FindsItsStartAndKeepsItsCalibrationWhenItBeginsAnew) {
  const InertialSlamSettings settings = expecting_much();
  Miscalibrated m = by_much(settings, 0.03);
  remove_samples(m.recording, 6, 6.7);  // the motion in between is unknown: a new part
  InertialSession session = session_for(m.recording, std::nullopt, settings);
  Estimates estimates = play(session, m.recording);
  EXPECT_EQ(session.report().resets, 1)
      << why_not_initialised(session.waited(), session.requirements());
  append(session.finish(), estimates);
  expect_sound(estimates);
  const Estimate* before = nullptr;
  const Estimate* anew = nullptr;
  for (const Estimate& e : estimates) {
    ASSERT_TRUE(e.calibration);
    if (e.time < after(m.recording, 6)) before = &e;
    if (!anew && e.time > after(m.recording, 6.7)) anew = &e;
  }
  ASSERT_TRUE(before && anew);
  const Eigen::VectorXd estimated = before->calibration->covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd kept = anew->calibration->covariance.diagonal().cwiseSqrt();
  EXPECT_LT(estimated[6], 1e-3);
  EXPECT_LT(kept.cwiseQuotient(estimated).maxCoeff(), 1.05);
  const Eigen::VectorXd error = calibration_error(m.truth, *estimates.back().calibration);
  EXPECT_LT(error.head<3>().norm(), 0.006);
  EXPECT_LT(std::abs(error[6]), 5e-4);
}

TEST(CalibratingSession, SurvivesAbsurdSamples) {
  const InertialSlamSettings settings = expecting_much();
  for (const double absurd : {1e5, 1e160, 1e308}) {
    Miscalibrated m = by_much(settings, 0.03);
    const std::size_t middle = m.recording.imu.size() / 2;
    for (const std::size_t k : {middle, middle + 1}) {  // a single one is bridged
      m.recording.imu[k].angular_rate_imu.setConstant(absurd);
    }
    InertialSession session = session_for(m.recording, std::nullopt, settings);
    const Estimates estimates = play(session, m.recording);
    expect_sound(estimates);
    EXPECT_GE(session.report().resets, 1) << absurd;
    EXPECT_TRUE(session.running()) << absurd;
    for (const Estimate& e : estimates) EXPECT_TRUE(e.calibration);
  }
}

// Garbage may change the offset, but time never runs backwards and the effect does not last.
TEST(CalibratingSession, SurvivesGarbage) {
  const InertialSlamSettings settings = expecting_much();
  Miscalibrated m = by_much(settings, 0.03);
  int k = 0;
  change_frames(m.recording, 4, 8, [&](FeatureFrame& frame) {
    for (PixelObservation& o : frame.pixels) {
      ++k;
      o.pixel = {(37 * k) % 699, (k * k + 53 * k) % 540};
    }
  });
  InertialSession session = session_for(m.recording, std::nullopt, settings);
  Estimates estimates = play(session, m.recording);
  const Estimates last = session.finish();
  estimates.insert(estimates.end(), last.begin(), last.end());
  expect_sound(estimates);
  ASSERT_FALSE(estimates.empty());
  EXPECT_GT(estimates.back().time, after(m.recording, 12));
  for (const Estimate& e : estimates) {
    ASSERT_TRUE(e.calibration);
    if (e.health == Health::kLost) continue;
    EXPECT_LT(std::abs(*e.calibration->time_offset), 0.1);
  }
  EXPECT_NEAR(*estimates.back().calibration->time_offset, 0.01, 2e-3);
}

}  // namespace
}  // namespace chasles
