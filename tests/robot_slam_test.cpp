#include "robot_slam.hpp"

#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include <chasles/data/run.hpp>
#include <chasles/error.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/sim/render_images.hpp>

// Drivers' messages, in the order in which threads may deliver them, against a run of the
// recording.
namespace chasles::app {
namespace {

using Estimates = std::vector<Estimate>;

const Recording& walk() {
  static const Recording recording = [] {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.hall_length = 8;
    s.hall_width = 6;
    s.sections = 1;
    s.rest_duration = 1;
    s.start_duration = 0.5;
    s.frame_rate = 15;
    s.focal_length = 200;
    s.image_width = 320;
    s.image_height = 240;
    s.center_u = 159.5;
    s.center_v = 119.5;
    return render_inertial(scene);
  }();
  return recording;
}

RobotSetup setup_of(const Recording& recording) {
  SensorCalibration calibration;
  calibration.cameras = recording.cameras;
  calibration.imu_convention = recording.imu_convention;
  calibration.imu_noise = *recording.imu_noise;
  calibration.exact_calibration = recording.exact_calibration;
  return {.calibration = calibration, .name = recording.name, .lossless = true};
}

/// What the callbacks get.
struct Received {
  Estimates estimates;
  std::vector<std::string> resets;

  RobotSlam::Callbacks callbacks() {
    return {.on_estimates =
                [this](std::span<const Estimate> more, VisualInertialSlam&) {
                  estimates.insert(estimates.end(), more.begin(), more.end());
                },
            .on_reset = [this](const std::string& why) { resets.push_back(why); }};
  }
};

/// Samples and images on a thread of their own each, which do not wait for each other.
void play(RobotSlam& slam) {
  std::thread samples([&] {
    for (const ImuSample& sample : walk().imu) slam.add(sample);
  });
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  samples.join();
}

void expect_the_run(const Estimates& found) {
  const Estimates expected = chasles::run(walk(), InertialRunSettings{}).estimates;
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].time, expected[i].time);
    EXPECT_EQ(found[i].world_T_imu.p, expected[i].world_T_imu.p) << i;
    EXPECT_EQ(found[i].covariance, expected[i].covariance) << i;
  }
}

std::string usage_error(const RobotSetup& setup) {
  try {
    const RobotSlam slam(setup, {});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "none";
}

TEST(RobotSlam, GivesTheBytesOfARunWhicheverTopicIsAhead) {
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  play(slam);
  slam.finish();
  expect_the_run(received.estimates);
  const RobotReport report = slam.report();
  EXPECT_EQ(report.samples, walk().imu.size());
  EXPECT_EQ(report.images.taken, walk().images->size());
  EXPECT_EQ(report.why_not_started, "");
  EXPECT_EQ(report.last->time, received.estimates.back().time);
  EXPECT_GT(report.worst_latency.value(), 0);
  EXPECT_FALSE(slam.report().mean_latency);  // none since
}

TEST(RobotSlam, PredictsAtTheLatestSampleAlthoughEstimatesWaitForImages) {
  RobotSlam slam(setup_of(walk()), {});
  const std::size_t frames = walk().images->size();
  auto sample = walk().imu.begin();
  const auto add_samples_until = [&](Time time) {
    for (; sample != walk().imu.end() && sample->time < time; ++sample) slam.add(*sample);
  };
  for (std::size_t i = 0; i < frames; ++i) {
    add_samples_until(walk().images->time(i));
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  add_samples_until(walk().images->time(frames - 1) + std::chrono::milliseconds(50));
  while (slam.report().images.waiting > 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  slam.ask([](VisualInertialSlam&) {});  // after the image that was taken last
  const Time last_estimate = slam.report().last.value().time;
  for (int ms : {100, 110, 120}) {  // samples that no image needs yet
    const ImuSample later{.time = last_estimate + std::chrono::milliseconds(ms),
                          .specific_force_imu = {0, 0, kStandardGravity},
                          .angular_rate_imu = {0, 0, 0.5}};
    slam.add(later);
    const auto state = slam.predicted(later.time);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->since_estimate, std::chrono::milliseconds(ms));
    EXPECT_NEAR(state->angular_rate_imu.z(), 0.5, 0.05);
  }
}

TEST(RobotSlam, AClockThatJumpsBackBeginsTheRunAnew) {
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  slam.add(ImuSample{.time = walk().imu.back().time + std::chrono::seconds(1),
                     .specific_force_imu = {0, 0, kStandardGravity}});
  for (const ImuSample& sample : walk().imu) slam.add(sample);
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  slam.add(0, walk().images->time(0), {});
  EXPECT_EQ(received.resets, (std::vector<std::string>{"the stamps of the IMU jumped back",
                                                       "the stamps of cam0 jumped back"}));
  EXPECT_EQ(slam.report().resets, 2);
  EXPECT_EQ(slam.report().samples, 0u);
}

TEST(RobotSlam, AfterAResetARunIsAsTheFirst) {
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  play(slam);
  slam.reset("asked");
  received.estimates.clear();
  play(slam);
  slam.finish();
  expect_the_run(received.estimates);
  EXPECT_EQ(received.resets, std::vector<std::string>{"asked"});
}

TEST(RobotSlam, AnErrorOnTheEstimatorsThreadBeginsTheRunAnew) {
  std::mutex mutex;  // both topics' threads find the error
  std::vector<std::string> resets;
  RobotSlam slam(setup_of(walk()), {.on_estimates =
                                        [](auto, VisualInertialSlam&) {
                                          throw Error(ExitCode::kDiverged, "no minimum");
                                        },
                                    .on_reset =
                                        [&](const std::string& why) {
                                          const std::lock_guard lock(mutex);
                                          resets.push_back(why);
                                        }});
  play(slam);
  slam.report();
  slam.add(walk().imu.back());
  ASSERT_FALSE(resets.empty());
  EXPECT_EQ(resets[0], "the estimator ended: no minimum");
}

TEST(RobotSlam, AnImageOfAnotherSizeIsAnError) {
  RobotSlam slam(setup_of(walk()), {});
  GrayImage image{.width = 7, .height = 1, .pixels = std::vector<std::uint8_t>(7)};
  try {
    slam.add(0, Time(1), image);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "cam0: an image has 7 x 1 pixels, expected 320 x 240 as in the calibration");
  }
}

TEST(RobotSlam, WritesTheRunFolderAndTheMapOfARun) {
  RobotSetup setup = setup_of(walk());
  setup.saves_map = setup.keeps_run = true;
  Received received;
  RobotSlam slam(setup, received.callbacks());
  EXPECT_THROW(slam.save_map(std::filesystem::path(::testing::TempDir()) / "early.map"),
               UsageError);
  play(slam);
  slam.finish();
  const auto folder = std::filesystem::path(::testing::TempDir()) / "robot_slam_run";
  slam.write_run(folder);
  const chasles::Run run = read_run(folder);
  ASSERT_EQ(run.states.size(), received.estimates.size());
  EXPECT_EQ(run.states.back().world_T_imu.p, received.estimates.back().world_T_imu.p);
  EXPECT_EQ(run.smoothed.size(), run.states.size());
  EXPECT_GT(run.landmarks.size(), 50u);
  EXPECT_GT(run.landmarks.back().first_seen, Time{});
  EXPECT_GT(run.landmarks.back().last_seen, run.landmarks.back().first_seen);
  const std::string saved = slam.save_map(folder / "walk.map");
  EXPECT_NE(saved.find("landmarks"), std::string::npos) << saved;
  EXPECT_THROW(slam.save_map(folder / "none" / "walk.map"), UsageError);
}

TEST(RobotSlam, SettingsThatCannotBeUsedAreErrors) {
  RobotSetup setup = setup_of(walk());
  setup.settings.estimator = estimator_choice("batch");
  EXPECT_NE(usage_error(setup).find("found 'batch', expected filter or window:N"),
            std::string::npos);
  setup.settings.estimator = estimator_choice("window:5");
  setup.saves_map = true;
  EXPECT_EQ(usage_error(setup), "maps are for the filter, not for the estimator window:5");
  setup = setup_of(walk());
  setup.calibration.cameras.clear();
  EXPECT_EQ(usage_error(setup), "the calibration has no camera, expected one or more");
}

}  // namespace
}  // namespace chasles::app
