#include <limits>

#include <gtest/gtest.h>

#include <chasles/imu/sample_screen.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/sim/inertial_sim.hpp>

// The screen of an estimator is the door of all IMU samples: what is behind it are measurements.
namespace chasles {
namespace {

// A walk with a sample that is not finite, one that is repeated, and six zeros for 0.6 s, which end
// a part of the run.
Recording faulty_walk() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 8;
  scene.settings.sections = 1;
  scene.settings.rest_duration = 1.5;
  Recording recording = simulate_inertial(scene);
  std::vector<ImuSample>& imu = recording.imu;
  imu[300].specific_force_imu.x() = std::numeric_limits<double>::quiet_NaN();
  imu[400].time = imu[399].time;
  const Time begin = imu[600].time;
  for (std::size_t i = 600; imu[i].time - begin < from_seconds(0.6); ++i) {
    imu[i] = {.time = imu[i].time};
  }
  return recording;
}

TEST(ImuDoor, AllEstimatorsTakeTheMeasurementsThatOneScreenReleases) {
  const Recording recording = faulty_walk();
  SampleScreen screen(recording.imu_range);
  std::vector<Time> expected;
  for (const ImuSample& sample : recording.imu) {
    for (const ImuSample& measured : screen.add(sample)) expected.push_back(measured.time);
  }
  for (const char* name : {"filter", "window:5", "batch"}) {
    SCOPED_TRACE(name);
    InertialRunSettings settings;
    settings.estimator = estimator_choice(name);
    const auto estimator = make_estimator(settings, recording);
    std::vector<Time> measured;
    EventStream events(recording);
    while (const auto event = events.next()) {
      const auto* sample = std::get_if<ImuSample>(&*event);
      const auto* frame = std::get_if<FeatureFrame>(&*event);
      if (sample) estimator->process(*sample);
      if (frame) estimator->process(*frame);
      for (const ImuSample& one : estimator->measured()) measured.push_back(one.time);
    }
    EXPECT_EQ(measured, expected);
    const EstimatorReport report = estimator->report();
    EXPECT_EQ(report.imu.not_finite, 1);
    EXPECT_EQ(report.imu.not_later, 1);
    EXPECT_EQ(report.imu.zero, screen.counts().zero);
    EXPECT_GT(report.imu.zero, 50);
    EXPECT_EQ(report.resets, 1) << "the zeros are a gap";
  }
}

}  // namespace
}  // namespace chasles
