#include "robot_slam.hpp"

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/split_imu.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/small_walk_testing.hpp>

// Drivers' messages, in the order in which threads may deliver them, against a run of the
// recording.
namespace chasles::app {
namespace {

using Estimates = std::vector<Estimate>;

const Recording& walk() {
  static const Recording recording = render_inertial(test::small_walk());
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
  std::vector<std::string> resets, written, not_written;

  RobotSlam::Callbacks callbacks() {
    return {.on_estimates =
                [this](std::span<const Estimate> more, VisualInertialSlam&) {
                  estimates.insert(estimates.end(), more.begin(), more.end());
                },
            .on_reset = [this](const std::string& why) { resets.push_back(why); },
            .on_output =
                [this](const std::string& sentence, bool is_there) {
                  (is_there ? written : not_written).push_back(sentence);
                }};
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

void expect_the_run(const Estimates& found, const Recording& recording = walk()) {
  const Estimates expected = chasles::run(recording, InertialRunSettings{}).estimates;
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

/// The walk's IMU as two sensors: the accelerometer has every second sample, 1 ms later.
struct ApartImu {
  SensorStream forces{.name = "/accel", .samples = {}}, rates{.name = "/gyro", .samples = {}};
  ApartImu() {
    for (std::size_t i = 0; i < walk().imu.size(); ++i) {
      const ImuSample& s = walk().imu[i];
      rates.samples.push_back({.time = s.time, .value = s.angular_rate_imu});
      if (i % 2 != 0) continue;
      forces.samples.push_back(
          {.time = s.time + std::chrono::milliseconds(1), .value = s.specific_force_imu});
    }
  }
  Recording joined() const {
    Recording recording = walk();
    join_streams("walk", forces, rates, Eigen::Matrix3d::Identity(), recording);
    return recording;
  }
};

/// Each topic on a thread of its own.
void play(RobotSlam& slam, const ApartImu& imu, std::atomic<std::size_t>& joined) {
  std::thread rates([&] {
    for (const AxesSample& rate : imu.rates.samples) joined += slam.add_rate(rate).size();
  });
  std::thread forces([&] {
    for (const AxesSample& force : imu.forces.samples) joined += slam.add_force(force).size();
  });
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  rates.join();
  forces.join();
}

TEST(RobotSlam, AnAccelerometerAndAGyroscopeApartGiveTheBytesOfARun) {
  const ApartImu imu;
  const Recording expected = imu.joined();
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  std::atomic<std::size_t> joined = 0;
  play(slam, imu, joined);
  slam.finish();
  expect_the_run(received.estimates, expected);
  const RobotReport report = slam.report();
  EXPECT_EQ(report.samples, expected.imu.size());
  EXPECT_EQ(report.joined.joined, expected.imu.size());
  EXPECT_EQ(joined, expected.imu.size());
  EXPECT_EQ(report.joined.forces, imu.forces.samples.size());
  EXPECT_EQ(report.joined.before_forces, 1u);
}

// A recording that is played again, one topic after the other.
TEST(RobotSlam, AClockThatJumpsBackBeginsBothSensorsAnew) {
  const ApartImu imu;
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  std::atomic<std::size_t> joined = 0;
  play(slam, imu, joined);
  slam.add_force(imu.forces.samples[0]);
  play(slam, imu, joined);
  slam.finish();
  EXPECT_EQ(received.resets.size(), 1u);
  EXPECT_GT(joined, 2 * imu.rates.samples.size() - 20);
}

// However far a topic is ahead.
TEST(RobotSlam, GivesTheBytesOfARunWhoseSamplesComeAfterAllImages) {
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  for (const ImuSample& sample : walk().imu) slam.add(sample);
  slam.finish();
  expect_the_run(received.estimates);
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
  for (const int ms : {1000, 1005}) {
    slam.add(ImuSample{.time = walk().imu.back().time + std::chrono::milliseconds(ms),
                       .specific_force_imu = {0, 0, kStandardGravity}});
  }
  for (const ImuSample& sample : walk().imu) slam.add(sample);
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  for (const std::size_t first : {0, 1}) slam.add(0, walk().images->time(first), {});
  EXPECT_EQ(received.resets, (std::vector<std::string>{"the stamps of the IMU jumped back",
                                                       "the stamps of cam0 jumped back"}));
  EXPECT_EQ(slam.report().resets, 2);
  EXPECT_EQ(slam.report().samples, 0u);
}

// A driver's glitch: the run goes on without that message.
TEST(RobotSlam, OneWrongStampChangesNothing) {
  Received received;
  RobotSlam slam(setup_of(walk()), received.callbacks());
  const auto glitch = [](Time time) {
    return ImuSample{.time = time, .specific_force_imu = {0, 0, kStandardGravity}};
  };
  for (std::size_t i = 0; i < walk().imu.size(); ++i) {
    slam.add(walk().imu[i]);
    if (i == 300) slam.add(glitch(walk().imu[i].time + std::chrono::hours(1)));
    if (i == 500) slam.add(glitch(walk().imu[i].time - std::chrono::seconds(1)));
  }
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
    if (i == 20) slam.add(0, walk().images->time(i) + std::chrono::hours(9), {});
  }
  slam.finish();
  expect_the_run(received.estimates);
  EXPECT_TRUE(received.resets.empty());
  EXPECT_EQ(slam.report().wrong_stamps, 3);
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
  for (;;) {  // until a call finds it
    slam.add(walk().imu.back());
    const std::lock_guard lock(mutex);
    if (!resets.empty()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
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

RobotSetup setup_with_outputs(const std::string& name) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  RobotSetup setup = setup_of(walk());
  setup.output = folder / "run";
  setup.save_map = folder / "walk.map";
  return setup;
}

void expect_run_of(const std::filesystem::path& folder, const Estimates& estimates) {
  const chasles::Run run = read_run(folder);
  ASSERT_EQ(run.states.size(), estimates.size());
  EXPECT_EQ(run.states.back().world_T_imu.p, estimates.back().world_T_imu.p);
  EXPECT_EQ(run.smoothed.size(), run.states.size());
  EXPECT_GT(run.landmarks.size(), 50u);
  EXPECT_GT(run.landmarks.back().first_seen, Time{});
  EXPECT_GT(run.landmarks.back().last_seen, run.landmarks.back().first_seen);
}

TEST(RobotSlam, WritesTheRunFolderAndTheMapOfARun) {
  const RobotSetup setup = setup_with_outputs("robot_slam_run");
  Received received;
  RobotSlam slam(setup, received.callbacks());
  EXPECT_THROW(slam.save_map(), UsageError);
  play(slam);
  slam.finish();
  slam.write_outputs();
  expect_run_of(setup.output, received.estimates);
  ASSERT_EQ(received.written.size(), 2u);
  EXPECT_EQ(received.written[0], "run folder: " + setup.output.string());
  EXPECT_NE(received.written[1].find("walk.map: "), std::string::npos) << received.written[1];
  EXPECT_TRUE(std::filesystem::exists(setup.save_map));
}

// The last run may be short: what the one before it had is not lost.
TEST(RobotSlam, KeepsTheOutputsOfARunThatIsStartedAnew) {
  const RobotSetup setup = setup_with_outputs("robot_slam_kept");
  const auto folder = setup.output.parent_path();
  Received received;
  RobotSlam slam(setup, received.callbacks());
  play(slam);
  slam.reset("asked");
  slam.reset("asked again");  // of nothing
  for (const ImuSample& sample : walk().imu) slam.add(sample);
  slam.finish();
  EXPECT_THROW(slam.write_outputs(), UsageError);  // no landmark for a map
  const Estimates expected = chasles::run(walk(), InertialRunSettings{}).estimates;
  expect_run_of(folder / "run-1", expected);
  EXPECT_TRUE(std::filesystem::exists(folder / "walk-1.map"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run-2"));
  EXPECT_FALSE(std::filesystem::exists(folder / "walk.map"));
  EXPECT_TRUE(std::filesystem::exists(folder / "run"));
}

// An error at the very end, or of the program's own, costs no output.
TEST(RobotSlam, WritesWhatThereIsAfterAnError) {
  const RobotSetup setup = setup_with_outputs("robot_slam_error");
  Received received;
  RobotSlam::Callbacks callbacks = received.callbacks();
  const Time last = walk().images->time(walk().images->size() - 20);
  callbacks.on_estimates = [&](std::span<const Estimate> estimates, VisualInertialSlam&) {
    if (estimates.back().time > last) throw Error(ExitCode::kDiverged, "no minimum");
  };
  RobotSlam slam(setup, callbacks);
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    slam.add(0, walk().images->time(i), walk().images->read(i).images[0]);
  }
  for (const ImuSample& sample : walk().imu) {  // until shortly before the error
    if (sample.time < last) slam.add(sample);
  }
  slam.finish();
  try {
    slam.write_outputs();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "no minimum");
  }
  EXPECT_GT(read_run(setup.output).states.size(), 20u);
  EXPECT_FALSE(std::filesystem::exists(setup.save_map));  // it may be wrong
  ASSERT_EQ(received.not_written.size(), 1u);
  EXPECT_EQ(received.not_written[0], "no minimum");
}

TEST(RobotSlam, ThrowsTheErrorOfTheProgramOnceAllIsWritten) {
  const RobotSetup setup = setup_with_outputs("robot_slam_own_error");
  RobotSlam slam(setup, {});
  play(slam);
  slam.finish();
  EXPECT_THROW(slam.write_outputs(error_of([] { throw InputError("damaged"); })), InputError);
  EXPECT_TRUE(std::filesystem::exists(setup.output / "states.csv"));
  EXPECT_TRUE(std::filesystem::exists(setup.save_map));
}

// The estimator is blocked: a report comes all the same, and no more than some images wait.
TEST(RobotSlam, AReportWaitsForNoEstimate) {
  std::mutex mutex;
  std::unique_lock stand_still(mutex);
  RobotSlam slam(setup_of(walk()), {.on_estimates = [&](auto, VisualInertialSlam&) {
                   const std::lock_guard lock(mutex);
                 }});
  std::thread player([&] { play(slam); });
  while (slam.report().images.waiting < 10) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const RobotReport report = slam.report();
  EXPECT_LE(report.images.waiting, 16u);
  EXPECT_EQ(report.why_not_started, "");
  stand_still.unlock();
  player.join();
  slam.finish();
  EXPECT_EQ(slam.report().images.taken, walk().images->size());
}

// A program discards the old run in on_reset: no estimate of it may come afterwards.
TEST(RobotSlam, NoEstimateOfAnEndedRunComesAfterTheReset) {
  std::atomic<bool> was_reset = false, came_late = false;
  RobotSlam slam(setup_of(walk()), {.on_estimates =
                                        [&](auto, VisualInertialSlam&) {
                                          std::this_thread::sleep_for(std::chrono::milliseconds(2));
                                          came_late = came_late || was_reset;
                                        },
                                    .on_reset = [&](const std::string&) { was_reset = true; }});
  play(slam);
  while (!slam.has_estimate()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  slam.reset("asked");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_FALSE(came_late);
}

TEST(RobotSlam, SettingsThatCannotBeUsedAreErrors) {
  RobotSetup setup = setup_of(walk());
  setup.settings.estimator = estimator_choice("batch");
  EXPECT_NE(usage_error(setup).find("found 'batch', expected filter or window:N"),
            std::string::npos);
  setup.settings.estimator = estimator_choice("window:5");
  setup.save_map = "walk.map";
  EXPECT_EQ(usage_error(setup), "maps are for the filter, not for the estimator window:5");
  setup = setup_of(walk());
  setup.calibration.cameras.clear();
  EXPECT_EQ(usage_error(setup), "the calibration has no camera, expected one or more");
}

}  // namespace
}  // namespace chasles::app
