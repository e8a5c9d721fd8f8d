#include <utility>

#include <chasles/base/interruption.hpp>
#include <chasles/lab/batch_trial.hpp>

namespace chasles {

InertialBatchInput batch_input(const Recording& recording, const InertialSlamSettings& settings,
                               const InertialStart& start) {
  InertialBatchInput input = batch_input(
      InertialSensors{
          .cameras = recording.cameras,
          .noise = recording.imu_noise.value_or(ImuNoise{}),
          .imu = {.convention = recording.imu_convention},
          .pixel_sigma = settings.pixel_sigma.value_or(recording.single_pixel_sigma.value_or(1))},
      settings, start);
  input.samples = recording.imu;
  input.frames = recording.frames;
  return input;
}

BatchTrial run_batch_trial(const FilterVariant& filter, const BatchSettings& settings,
                           const Recording& recording, const InertialStart& start,
                           std::vector<TimedMotion> initial) {
  InertialBatchInput input = batch_input(recording, filter.settings, start);
  input.initial = std::move(initial);
  InertialBatchResult result = smooth(input, filter.settings.chart, settings, &interruption_wanted);
  BatchTrial batch{.trial = {.filter = filter.name}, .report = result.report};
  for (const Estimate& e : result.estimates) {
    if (!add_to_trial(filter.settings.chart, recording, start.time, e, batch.trial)) break;
  }
  batch.trial.map = std::move(result.landmarks);
  batch.trial.seconds_cpu = result.report.seconds_solve + result.report.seconds_covariance;
  end_trial(recording, batch.trial);
  return batch;
}

Trial run_window_trial(const FilterVariant& filter, const BatchSettings& settings,
                       const Recording& recording, const InertialStart& start) {
  InertialWindowResult result = slide(batch_input(recording, filter.settings, start),
                                      filter.settings.chart, settings, filter.estimator.keyframes);
  Trial trial{.filter = filter.name};
  for (const Estimate& e : result.estimates) {
    if (!add_to_trial(filter.settings.chart, recording, start.time, e, trial)) break;
  }
  trial.map = std::move(result.landmarks);
  end_trial(recording, trial);
  return trial;
}

std::vector<TimedMotion> filter_motions(const FilterVariant& filter, const Recording& recording,
                                        const InertialStart& start) {
  std::vector<TimedMotion> motions;
  run_filter(filter, recording, start, [&](const Estimate& e) {
    motions.push_back(timed_motion(e, from_seconds(filter.settings.initial_time_offset())));
    return e.health != Health::kLost;
  });
  return motions;
}

}  // namespace chasles
