#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

Recording short_hallway() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 8;
  scene.settings.hall_width = 8;
  scene.settings.sections = 1;
  return simulate_inertial(scene);
}

FilterVariant own_filter() { return {.name = "own", .settings = {}}; }

Trial run(const Recording& recording, const FilterVariant& filter = own_filter()) {
  return run_trial(filter, recording, draw_start(recording, filter.settings, 1, 0));
}

TEST(Start, ErrsAsItsSettingsSay) {
  const Recording recording = short_hallway();
  const InertialSlamSettings settings;
  const SE3& truth = recording.truth.front().pose;
  const Eigen::Vector3d v = recording.true_motion.front().v_world;
  double tilt = 0, speed = 0;
  constexpr int kDraws = 400;
  for (std::uint64_t i = 0; i < kDraws; ++i) {
    const InertialStart start = draw_start(recording, settings, 1, i);
    EXPECT_EQ(start.time, recording.frames.front().time);
    EXPECT_EQ(start.nav_T_imu.p, truth.p);
    const Eigen::Vector3d error = so3::log(truth.R * start.nav_T_imu.R.transpose());
    EXPECT_LT(std::abs(error.z()), 1e-12) << "the heading is known";
    tilt += error.squaredNorm() / std::pow(settings.initial_tilt_sigma, 2);
    speed += (v - start.v_nav).squaredNorm() / std::pow(settings.initial_velocity_sigma, 2);
  }
  EXPECT_TRUE(chi2_band(2, kDraws, 0.999).contains(tilt / kDraws)) << tilt / kDraws;
  EXPECT_TRUE(chi2_band(3, kDraws, 0.999).contains(speed / kDraws)) << speed / kDraws;
}

// The filter's first pose is given; errors grow with the way. The truth is drawn anew in each run.
TEST(Trial, TheSmoothedPathIsMoreAccurateAndConsistent) {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 8;
  scene.settings.hall_width = 8;
  scene.settings.sections = 1;
  FilterVariant filter = own_filter();
  filter.settings.exact_map = Toggle::kTrue;
  constexpr int kRuns = 12;
  double error = 0, smoothed_error = 0, nees = 0;
  for (std::uint64_t i = 0; i < kRuns; ++i) {
    scene.settings.seed = 100 + i;
    const Recording recording = simulate_inertial(scene);
    const Trial trial =
        run_trial(filter, recording, draw_start(recording, filter.settings, 7, i), KeepMap::kYes);
    ASSERT_EQ(trial.smoothed.size(), trial.points.size());
    const std::size_t last = trial.points.size() - 1, middle = last / 2;
    EXPECT_NEAR(trial.smoothed[last].position_error, trial.points[last].position_error, 1e-9)
        << "at the end both have the same measurements";
    error += trial.points[middle].position_error / kRuns;
    smoothed_error += trial.smoothed[middle].position_error / kRuns;
    nees += trial.smoothed[middle].nees_pose / kRuns;
  }
  EXPECT_LT(smoothed_error, error);
  EXPECT_TRUE(chi2_band(6, kRuns, 0.999).contains(nees)) << nees;
}

// Twice around the block: in the second round the landmarks of the first come into view again.
TEST(Trial, ReturningLandmarksCloseTheLoopConsistently) {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 8;
  scene.settings.hall_width = 8;
  scene.settings.sections = 8;
  scene.settings.keep_ids = true;
  scene.settings.frame_rate = 10;
  FilterVariant open = own_filter(), closes = own_filter();
  closes.settings.recognise = Recognise::kIds;
  closes.settings.exact_map = Toggle::kTrue;
  constexpr int kRuns = 4;
  double error = 0, closed_error = 0, nees = 0, smoothed_nees = 0;
  for (std::uint64_t i = 0; i < kRuns; ++i) {
    scene.settings.seed = 300 + i;
    const Recording recording = simulate_inertial(scene);
    const InertialStart start = draw_start(recording, closes.settings, 7, i);
    const Trial drifts = run_trial(open, recording, start);
    const Trial trial = run_trial(closes, recording, start, KeepMap::kYes);
    ASSERT_EQ(trial.points.size(), drifts.points.size());
    EXPECT_LT(trial.map.size(), 0.7 * drifts.landmarks) << "each place is in the map once";
    const std::size_t last = trial.points.size() - 1, first_round = last * 3 / 8;
    error += drifts.points[last].position_error / kRuns;
    closed_error += trial.points[last].position_error / kRuns;
    nees += trial.points[last].nees_pose / kRuns;
    smoothed_nees += trial.smoothed[first_round].nees_pose / kRuns;
  }
  EXPECT_LT(closed_error, 0.7 * error);
  const Band band = chi2_band(6, kRuns, 0.999);
  EXPECT_TRUE(band.contains(nees)) << nees;
  EXPECT_TRUE(band.contains(smoothed_nees)) << smoothed_nees;
}

TEST(Trial, OnAShortHallwayIsCloseToTheTruthAndSaysSo) {
  const Recording recording = short_hallway();
  const Trial trial = run(recording);
  EXPECT_FALSE(trial.diverged);
  EXPECT_EQ(trial.points.size(), recording.frames.size());
  EXPECT_EQ(trial.estimate.size(), recording.frames.size());
  EXPECT_GT(trial.landmarks, 20);
  const TrialAverages a = averages(trial);
  EXPECT_LT(a.position_error, 0.3);
  EXPECT_LT(a.attitude_error, 0.01);
  EXPECT_GT(a.nees_pose, 0.5);
  EXPECT_LT(a.nees_pose, 30);
  EXPECT_NEAR(a.nis_per_dof, 1, 0.15);
}

TEST(Trial, IsTheSameAgain) {
  const Recording recording = short_hallway();
  const TrialAverages a = averages(run(recording)), b = averages(run(recording));
  EXPECT_EQ(a.position_error, b.position_error);
  EXPECT_EQ(a.nees_pose, b.nees_pose);
}

TEST(Trial, HasNoErrorWhereTheTruthIsNotKnown) {
  Recording recording = short_hallway();
  recording.truth.erase(recording.truth.begin() + 50, recording.truth.begin() + 60);
  const Trial trial = run(recording);
  EXPECT_FALSE(trial.diverged);
  EXPECT_TRUE(std::isnan(trial.points[55].position_error));
  EXPECT_TRUE(std::isnan(trial.points[55].nees_pose));
  EXPECT_GT(trial.points[55].nis_dof, 0);
  EXPECT_TRUE(std::isfinite(trial.points[60].position_error));
  EXPECT_TRUE(std::isfinite(averages(trial).position_error));
}

TEST(Trial, EndsWhereItDiverges) {
  Recording recording = short_hallway();
  for (std::size_t i = 100; i < recording.truth.size(); ++i) recording.truth[i].pose.p.x() += 25;
  const Trial trial = run(recording);
  EXPECT_TRUE(trial.diverged);
  EXPECT_EQ(trial.points.size(), 101u);
}

TEST(Trial, RejectsWhatLacksSomething) {
  const Recording whole = short_hallway();
  const auto rejected = [&](auto change) {
    Recording recording = whole;
    change(recording);
    EXPECT_THROW(run(recording), InputError);
  };
  rejected([](Recording& r) { r.truth.clear(); });
  rejected([](Recording& r) { r.frames.clear(); });
  rejected([](Recording& r) { r.imu.clear(); });
  rejected([](Recording& r) { r.cameras.clear(); });
}

}  // namespace
}  // namespace chasles
