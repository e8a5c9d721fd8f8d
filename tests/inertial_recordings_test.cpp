// The visual-inertial filter on real and realistic recordings: EuRoC's AprilGrid walk with its
// pixels and IMU, and a long walk along a real trajectory. docs/inertial-results.md has the
// figures.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <tuple>

#include <gtest/gtest.h>

#include <chasles/eval/evaluation.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

fs::path data() {
  const char* set = std::getenv("CHASLES_DATA");
  return set ? fs::path(set) : fs::path(CHASLES_SOURCE_DIR) / "../shared/data";
}

double figure(const Trial& trial, const Recording& recording, const std::string& wanted) {
  for (const auto& [name, value] : figures(evaluate(trial.estimate, recording.truth, {}, {}))) {
    if (name == wanted) return value.value();
  }
  ADD_FAILURE() << "no figure " << wanted;
  return 0;
}

// Same settings as studies/configs/euroc.yaml.
FilterVariant euroc(const std::string& chart) {
  FilterVariant filter{.name = chart, .settings = {}};
  auto& s = filter.settings;
  s.chart = chart;
  s.pixel_sigma = 0.5;
  s.initial_tilt_sigma = 0.01;
  s.initial_velocity_sigma = 0.1;
  s.initial_accelerometer_bias_sigma = 0.2;
  s.initial_gyroscope_bias_sigma = 0.1;
  s.waiting_frames = 2;
  return filter;
}

class AprilGrid : public testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(AprilGrid, IsFollowedThroughTheOutage) {
  const auto [chart, cameras] = GetParam();
  const fs::path folder = data() / "euroc/imu_april";
  if (!fs::exists(folder)) GTEST_SKIP() << "skipped: no recordings";
  Recording recording = read_recording(folder);
  recording.cameras.resize(static_cast<std::size_t>(cameras));
  for (FeatureFrame& frame : recording.frames) {
    std::erase_if(frame.pixels, [&, n = cameras](const auto& o) { return o.camera >= n; });
  }
  const Trial trial = run_trial(euroc(chart), recording, true_start(recording));
  EXPECT_FALSE(trial.diverged);
  EXPECT_LT(figure(trial, recording, "ate_m"), cameras == 2 ? 0.02 : 0.04);
  // The pixel noise is 0.3 px, the stated sigma 0.5 px; the gate rejects outliers.
  EXPECT_LT(averages(trial).nis_per_dof, 0.6);
}

// Batch estimation with every fourth frame is more accurate than the filter with all frames.
TEST(AprilGridBatch, ErrsLessThanTheFilter) {
  const fs::path folder = data() / "euroc/imu_april";
  if (!fs::exists(folder)) GTEST_SKIP() << "skipped: no recordings";
  const Recording recording = read_recording(folder);
  const FilterVariant filter = euroc("right-sen3");
  const InertialStart start = true_start(recording);
  BatchSettings settings;
  settings.frames_per_keyframe = 4;
  const BatchTrial batch =
      run_batch_trial(filter, settings, recording, start, filter_motions(filter, recording, start));
  EXPECT_TRUE(batch.report.converged) << batch.report.end;
  EXPECT_LT(batch.report.cost_per_dof, 0.6);  // as the filter's NIS
  EXPECT_LT(figure(batch.trial, recording, "ate_m"),
            0.9 * figure(run_trial(filter, recording, start), recording, "ate_m"));
}

INSTANTIATE_TEST_SUITE_P(Charts, AprilGrid,
                         testing::Combine(testing::Values("standard", "left-se3", "right-se3",
                                                          "right-sen3"),
                                          testing::Values(1, 2)),
                         [](const auto& test) {
                           std::string name = std::get<0>(test.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + std::to_string(std::get<1>(test.param));
                         });

TEST(LongWalk, StaysConsistentOverThreeMinutes) {
  const fs::path file = data() / "trajectories/udel_gore.txt";
  if (!fs::exists(file)) GTEST_SKIP() << "skipped: no recordings";
  InertialScene scene = inertial_scene("trajectory");
  scene.path = read_tum(file);
  auto& s = scene.settings;
  s.cameras = 2;
  s.baseline = 0.11;
  s.frame_rate = 10;
  s.imu_rate = 400;
  s.accelerometer_noise_density = 2e-3;
  s.accelerometer_random_walk = 3e-3;
  s.gyroscope_noise_density = 1.7e-4;
  s.gyroscope_random_walk = 1.9e-5;
  s.min_range = 1;
  FilterVariant filter;
  filter.settings.frames_per_clone = 1;
  const Recording recording = simulate_inertial(scene, 1);
  const Trial trial = run_trial(filter, recording, draw_start(recording, filter.settings, 1, 1));
  EXPECT_FALSE(trial.diverged);
  EXPECT_LT(figure(trial, recording, "ate_posyaw_m"), 0.06);
  EXPECT_LT(averages(trial).nees_pose, 12);
}

}  // namespace
}  // namespace chasles
