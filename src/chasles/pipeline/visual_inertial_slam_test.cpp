#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/batch_input.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/sim/small_walk_testing.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

using test::error_from;
using test::Estimates;

const Recording& walk() {
  static const Recording recording = render_inertial(test::small_walk());
  return recording;
}

VisualInertialSlam slam_for(const Recording& recording) {
  return {recording.cameras, *recording.imu_noise, {}, {.convention = recording.imu_convention}};
}

/// Feeds the events in the order of a recording.
Estimates play(VisualInertialSlam& slam, const Recording& recording) {
  Estimates all;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) append(slam.process(*sample), all);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) append(slam.process(recording.images->read(due->index)), all);
  }
  append(slam.finish(), all);
  return all;
}

void expect_the_same(const Estimates& a, const Estimates& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].time, b[i].time);
    EXPECT_EQ(a[i].world_T_imu.p, b[i].world_T_imu.p) << i;
    EXPECT_EQ(a[i].world_T_imu.R, b[i].world_T_imu.R) << i;
    EXPECT_EQ(a[i].covariance, b[i].covariance) << i;
    EXPECT_EQ(a[i].used, b[i].used) << i;
  }
}

// What one run leaves, another one of a robot's program finds.
TEST(VisualInertialSlam, FindsItsPlaceInAMap) {
  InertialRunSettings settings;
  settings.filter.recognise = Recognise::kAppearance;
  const auto made = [&](std::shared_ptr<const LandmarkMap> map) {
    return VisualInertialSlam(walk().cameras, *walk().imu_noise, settings,
                              {.convention = walk().imu_convention}, {}, std::move(map));
  };
  VisualInertialSlam first = made(nullptr);
  play(first, walk());
  const auto map = std::make_shared<const LandmarkMap>(first.estimator().landmark_map().value());
  VisualInertialSlam second = made(map);
  const Estimates estimates = play(second, walk());
  ASSERT_TRUE(estimates.back().in_map);
  // The same walk, so both frames are one, up to the errors of the map.
  const PoseInMap& pose = *estimates.back().in_map;
  const double sigma = std::sqrt(pose.covariance.bottomRightCorner<3, 3>().trace());
  EXPECT_LT((pose.map_T_imu.p - estimates.back().world_T_imu.p).norm(), 4 * sigma);
  EXPECT_LT(sigma, 0.3);
}

TEST(VisualInertialSlam, KeepsTheScaleWithOneCameraWhereTheChartCan) {
  InertialRunSettings settings;
  EXPECT_EQ(for_images(settings, 1, {}).filter.keep_scale, Toggle::kTrue);
  EXPECT_EQ(for_images(settings, 2, {}).filter.keep_scale, Toggle::kAuto);
  settings.filter.chart = "left-se3";
  EXPECT_EQ(for_images(settings, 1, {}).filter.keep_scale, Toggle::kAuto);
  settings = {};
  settings.filter.keep_scale = Toggle::kFalse;
  EXPECT_EQ(for_images(settings, 1, {}).filter.keep_scale, Toggle::kFalse);
}

TEST(VisualInertialSlam, OnlyAFilterEstimatesTheTimeOffset) {
  InertialRunSettings settings;
  EXPECT_EQ(for_images(settings, 2, {}).filter.calibrate_time_offset, Calibrate::kTrue);
  settings.filter.calibrate_time_offset = Calibrate::kFalse;
  EXPECT_EQ(for_images(settings, 2, {}).filter.calibrate_time_offset, Calibrate::kFalse);
  settings = {.estimator = {.kind = EstimatorChoice::Kind::kBatch}};
  EXPECT_EQ(for_images(settings, 2, {}).filter.calibrate_time_offset, Calibrate::kAuto);
}

TEST(VisualInertialSlam, AnEstimatorKnowsTheNoiseOfTracksAndOfAnImuInMotion) {
  const InertialSlamSettings filter = for_images({}, 2, {}).filter;
  EXPECT_EQ(filter.track_drift, kFrontendTrackNoise.drift);
  EXPECT_EQ(filter.match_sigma, kFrontendTrackNoise.match);
  EXPECT_EQ(filter.track_sigma, kFrontendTrackNoise.sigma);
  EXPECT_EQ(filter.pixel_sigma, std::nullopt);
  EXPECT_EQ(filter.vibration_noise, 1);
  EXPECT_EQ(filter.imu_noise_scale, 3);
  const InertialSlamSettings simulated = for_images({}, 2, {.exact = true}).filter;
  EXPECT_EQ(simulated.vibration_noise, 0);
  EXPECT_EQ(simulated.imu_noise_scale, 1);
  EXPECT_EQ(simulated.track_sigma, kRenderedTrackNoise.sigma);
  const InertialSlamSettings rendered = for_images({}, 2, {}, true).filter;
  EXPECT_EQ(rendered.track_sigma, kRenderedTrackNoise.sigma);
  EXPECT_EQ(rendered.vibration_noise, 1);
  InertialRunSettings given;
  given.filter.track_drift = 0;
  given.filter.pixel_sigma = 0.5;
  given.filter.vibration_noise = 2;
  const InertialSlamSettings kept = for_images(given, 2, {.exact = true}).filter;
  EXPECT_EQ(kept.track_drift, 0);
  EXPECT_EQ(kept.track_sigma, std::nullopt);  // pixel_sigma
  EXPECT_EQ(kept.vibration_noise, 2);
  const InertialRunSettings batch{.estimator = {.kind = EstimatorChoice::Kind::kBatch}};
  const InertialRunSettings smoothing = for_images(batch, 2, {});
  EXPECT_EQ(smoothing.filter.track_sigma, kSmoothedTrackNoise.sigma);
  EXPECT_EQ(smoothing.filter.vibration_noise, 1);
  EXPECT_EQ(smoothing.batch.loss_width, 1);
  EXPECT_EQ(smoothing.batch.gate, 2);
  EXPECT_EQ(for_images(batch, 2, {.exact = true}).batch.loss_width, std::nullopt);
  const InertialBatchInput input = batch_input(
      {.cameras = {}, .noise = {}, .imu = {}, .pixel_sigma = 0.4}, smoothing.filter, {});
  EXPECT_EQ(input.pixel_sigma, kSmoothedTrackNoise.sigma);
  EXPECT_EQ(input.match_sigma, kSmoothedTrackNoise.match);
  EXPECT_EQ(input.imu.vibration_noise, 1);
}

TEST(VisualInertialSlam, GivesWhatTheProgramGives) {
  VisualInertialSlam slam = slam_for(walk());
  std::vector<Time> seen;
  slam.set_frame_observer([&](const FeatureFrame& frame) { seen.push_back(frame.time); });
  const Estimates own = play(slam, walk());
  ASSERT_GT(own.size(), 80u);
  EXPECT_EQ(seen.size(), walk().images->size());
  EXPECT_EQ(seen.back(), walk().images->time(seen.size() - 1));
  expect_the_same(own, chasles::run(walk(), InertialRunSettings{}).estimates);
  EXPECT_LT(error_from(own, walk()), 0.05);
  EXPECT_EQ(slam.estimator().report().resets, 0);
  EXPECT_GT(slam.report().tracked, 30);
  EXPECT_EQ(slam.waiting(), 0u);
}

TEST(VisualInertialSlam, GivesWhatTheProgramGivesWithEachEstimator) {
  for (const char* name : {"window:5", "batch"}) {
    InertialRunSettings settings;
    settings.estimator = estimator_choice(name);
    VisualInertialSlam slam(walk().cameras, *walk().imu_noise, settings,
                            {.convention = walk().imu_convention});
    Estimates own = play(slam, walk());
    const Estimates expected = chasles::run(walk(), settings).estimates;
    // What finish() returns for batch estimation replaces the filter's estimates.
    if (settings.estimator.is_batch()) own.erase(own.begin(), own.end() - std::ssize(expected));
    expect_the_same(own, expected);
    EXPECT_EQ(slam.estimator().report().batch.has_value(), settings.estimator.is_batch());
    EXPECT_TRUE(slam.finish().empty());  // once more: nothing is left
  }
}

TEST(VisualInertialSlam, FinishStopsOnRequest) {
  InertialRunSettings settings;
  settings.estimator = {.kind = EstimatorChoice::Kind::kBatch};
  VisualInertialSlam slam(walk().cameras, *walk().imu_noise, settings,
                          {.convention = walk().imu_convention});
  EventStream events(walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
    const auto* due = std::get_if<ImagesDue>(&*event);
    if (due) slam.process(walk().images->read(due->index));
  }
  EXPECT_TRUE(slam.finish([] { return true; }).empty());
}

TEST(VisualInertialSlam, ImagesMayComeBeforeTheirSamples) {
  VisualInertialSlam in_order = slam_for(walk()), ahead = slam_for(walk());
  Estimates all;
  std::size_t next = 0, most = 0;
  for (const ImuSample& sample : walk().imu) {
    for (; next < walk().images->size() &&
           walk().images->time(next) <= sample.time + std::chrono::milliseconds(150);
         ++next) {
      append(ahead.process(walk().images->read(next)), all);
    }
    most = std::max(most, ahead.waiting());
    append(ahead.process(sample), all);
  }
  append(ahead.finish(), all);
  EXPECT_GE(most, 2u);
  expect_the_same(all, play(in_order, walk()));
}

// All samples and images of the walk, each at the given place in the order of arrival.
Estimates play_in_order_of(const std::function<double(bool, std::size_t)>& place,
                           VisualInertialSlam& slam) {
  std::multimap<double, std::pair<bool, std::size_t>> order;
  for (std::size_t i = 0; i < walk().imu.size(); ++i) {
    order.insert({place(false, i), {false, i}});
  }
  for (std::size_t i = 0; i < walk().images->size(); ++i) {
    order.insert({place(true, i), {true, i}});
  }
  Estimates all;
  for (const auto& [_, event] : order) {
    const auto [is_image, i] = event;
    append(is_image ? slam.process(walk().images->read(i)) : slam.process(walk().imu[i]), all);
  }
  append(slam.finish(), all);
  return all;
}

double seconds_of(bool is_image, std::size_t i) {
  return to_seconds(is_image ? walk().images->time(i) : walk().imu[i].time);
}

TEST(VisualInertialSlam, AnyOrderOfArrivalGivesTheSameBytes) {
  VisualInertialSlam in_order = slam_for(walk());
  const Estimates expected = play(in_order, walk());
  ASSERT_GT(expected.size(), 80u);
  const auto number = [](std::size_t i) { return static_cast<double>(i); };
  const auto random = [](std::size_t i) {
    return static_cast<double>((i * 2654435761u) % 100003u) / 100003;
  };
  const std::map<std::string, std::function<double(bool, std::size_t)>> orders{
      {"all samples first",
       [&](bool is_image, std::size_t i) { return (is_image ? 1e6 : 0) + number(i); }},
      {"samples 1 s ahead",
       [](bool is_image, std::size_t i) { return seconds_of(is_image, i) - (is_image ? 0 : 1); }},
      {"images 1 s ahead",
       [](bool is_image, std::size_t i) { return seconds_of(is_image, i) - (is_image ? 1 : 0); }},
      {"all samples first, and shuffled",
       [&](bool is_image, std::size_t i) { return is_image ? 1e6 + number(i) : random(i); }},
      {"blocks of a second, the images first and shuffled",
       [&](bool is_image, std::size_t i) {
         return std::floor(seconds_of(is_image, i)) +
                (is_image ? .4 * random(i) : .5 + 1e-5 * number(i));
       }},
  };
  for (const auto& [name, place] : orders) {
    SCOPED_TRACE(name);
    VisualInertialSlam slam = slam_for(walk());
    expect_the_same(play_in_order_of(place, slam), expected);
    EXPECT_EQ(slam.arrivals().samples, walk().imu.size());
    EXPECT_EQ(slam.arrivals().samples_dropped + slam.arrivals().samples_late, 0u);
    EXPECT_EQ(slam.arrivals().images_late + slam.arrivals().images_uncovered, 0u);
  }
}

TEST(VisualInertialSlam, WhatIsLateOrRepeatedChangesNothing) {
  VisualInertialSlam clean = slam_for(walk()), disturbed = slam_for(walk());
  Estimates all;
  EventStream events(walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      append(disturbed.process(*sample), all);
      append(disturbed.process(*sample), all);
      append(disturbed.process(walk().imu.front()), all);
      continue;
    }
    const ImageFrame images = walk().images->read(std::get<ImagesDue>(*event).index);
    append(disturbed.process(images), all);
    append(disturbed.process(images), all);
  }
  append(disturbed.finish(), all);
  expect_the_same(all, play(clean, walk()));
  EXPECT_EQ(disturbed.arrivals().images_late, walk().images->size());
  EXPECT_GT(disturbed.arrivals().samples_late, walk().imu.size());
}

TEST(VisualInertialSlam, ImagesWithoutSamplesDoNotPileUp) {
  VisualInertialSlam slam = slam_for(walk());
  ImageFrame images = walk().images->read(0);
  std::size_t most = 0;
  for (int k = 0; k < 200; ++k) {
    images.time += std::chrono::milliseconds(50);
    EXPECT_TRUE(slam.process(images).empty());
    most = std::max(most, slam.waiting());
  }
  EXPECT_EQ(most, ArrivalOrder::kMostFrames);
  EXPECT_EQ(slam.arrivals().images_uncovered, 200 - ArrivalOrder::kMostFrames);
  for (int k = 0; k < 200; ++k) slam.process(images);  // a clock that does not advance
  EXPECT_LE(slam.waiting(), ArrivalOrder::kMostFrames);
  EXPECT_GE(slam.arrivals().images_late, 200u);
  EXPECT_GT(slam.estimator().report().dropped_frames, 100);
  EXPECT_EQ(slam.estimator().why_not_started().substr(0, 21), "not initialised after");
  EXPECT_NE(slam.estimator().why_not_started().find("IMU samples 0 of at least 1"),
            std::string::npos);
}

TEST(VisualInertialSlam, ASampleThatIsNotFiniteOrLateEndsNoWait) {
  VisualInertialSlam slam = slam_for(walk());
  slam.process(walk().imu[0]);
  slam.process(ImageFrame{.time = walk().imu[2].time, .images = walk().images->read(0).images});
  ASSERT_EQ(slam.waiting(), 1u);
  ImuSample broken = walk().imu[3];
  broken.angular_rate_imu.x() = std::numeric_limits<double>::quiet_NaN();
  slam.process(broken);
  slam.process(walk().imu[0]);
  EXPECT_EQ(slam.waiting(), 1u);
  slam.process(walk().imu[2]);
  EXPECT_EQ(slam.waiting(), 0u);
}

TEST(VisualInertialSlam, AnImageOfAnotherSizeIsLeftOutWithAnError) {
  VisualInertialSlam clean = slam_for(walk()), disturbed = slam_for(walk());
  Estimates all;
  EventStream events(walk());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) {
      append(disturbed.process(*sample), all);
      continue;
    }
    const ImageFrame images = walk().images->read(std::get<ImagesDue>(*event).index);
    ImageFrame torn = images;
    torn.images[0].height /= 2;
    torn.images[0].pixels.resize(torn.images[0].pixels.size() / 2);
    EXPECT_THROW(disturbed.process(torn), InputError);
    EXPECT_THROW(disturbed.process(ImageFrame{.time = images.time, .images = {}}), InputError);
    append(disturbed.process(images), all);
  }
  append(disturbed.finish(), all);
  expect_the_same(all, play(clean, walk()));
}

TEST(VisualInertialSlam, SettingsThatCannotBeUsedAreRejected) {
  EXPECT_THROW(VisualInertialSlam({}, *walk().imu_noise), UsageError);
  InertialRunSettings wrong;
  wrong.filter.chart = "none";
  const auto rejected = [](const InertialRunSettings& settings) {
    EXPECT_THROW(VisualInertialSlam(walk().cameras, *walk().imu_noise, settings), UsageError);
  };
  rejected(wrong);
  rejected({.frontend = {.window = 14}});
  rejected({.start = {.keyframes = 3}});
  InertialRunSettings unknown;
  unknown.filter.init = LandmarkInit{7};
  rejected(unknown);
}

}  // namespace
}  // namespace chasles
