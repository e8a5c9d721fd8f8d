#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/map_sketch.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/session/calibration_report.hpp>
#include <chasles/session/dead_reckoning.hpp>
#include <chasles/session/estimator_plan.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/remarks.hpp>
#include <chasles/session/summary.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> realtime(const SessionOptions& o) {
  if (!o.realtime && !o.realtime_speed) return std::nullopt;
  return o.realtime_speed.value_or(1);
}

// Above 1 for a window with fewer keyframes than frames.
template <typename Settings>
int frames_per_estimate(const Settings& settings) {
  return settings.estimator.is_window() ? settings.batch.frames_per_keyframe : 1;
}

// The true state, without a random error.
InertialStart start_at_truth(const Recording& recording, const RecordingInput& input) {
  if (is_offset_auto(input.truth_options)) {
    throw UsageError(
        "--begin truth needs the truth's clock before the run: expected --truth-time-offset in "
        "seconds, not auto");
  }
  if (!recording.truth_attitudes) {
    throw UsageError(
        fmt::format("--begin truth: the truth of {} has positions alone, expected one "
                    "with attitudes",
                    recording.name));
  }
  if (!recording.truth.empty() && !recording.truth_level.value_or(true)) {
    throw UsageError(fmt::format(
        "--begin truth: the truth of {} is not level (its calibration.yaml states it, or it begins "
        "at the identity), expected one whose z axis points up; --truth-level yes overrides this",
        recording.name));
  }
  if (recording.truth.empty()) {
    throw Error(
        ExitCode::kNotInitialised,
        fmt::format("{}: has no truth to start from (--truth FILE gives one); without --begin "
                    "truth the run initialises itself",
                    recording.name));
  }
  return true_start(recording);
}

bool uses_maps(const SessionOptions& o) { return !o.map.empty() || !o.save_map.empty(); }

void check_inertial(const SessionOptions& o) {
  if (uses_maps(o) && !o.settings.estimator.is_filter()) {
    throw UsageError("--map and --save-map are for the filter, not for --estimator " + o.estimator);
  }
  if (!o.settings.mode.empty() && o.settings.mode != "slam") {
    throw UsageError("--mode: a visual-inertial run supports only slam");
  }
  if (!o.full_covariance.empty()) {
    throw UsageError("--full-covariance is not available for a recording with an IMU");
  }
  if (o.begin != "auto" && o.begin != "truth") {
    throw UsageError(fmt::format("--begin: found '{}', expected auto or truth", o.begin));
  }
  if (!o.settings.estimator.is_filter() && realtime(o)) {
    throw UsageError("--realtime is for the filter, not for --estimator " + o.estimator);
  }
}

// The map in which the run looks for its place; null: none.
std::unique_ptr<SharedMap> prior_map(const SessionOptions& o, const Recording& recording) {
  if (o.map.empty()) return nullptr;
  auto shared = std::make_unique<SharedMap>(o.map);
  const std::vector<MapSession>& sessions = shared->map()->sessions;
  if (std::ranges::find(sessions, recording.name, &MapSession::name) != sessions.end()) {
    spdlog::warn(
        "{} has a session of a recording named {}, as this one is: if it is the same, its "
        "information counts twice",
        o.map.string(), recording.name);
  }
  return shared;
}

bool has_rolling_shutter(const Recording& recording) {
  return std::ranges::any_of(recording.cameras,
                             [](const Camera& camera) { return camera.shutter.is_rolling(); });
}

PreparedEstimator prepare(const SessionOptions& o, InertialRunSettings settings,
                          Recording& recording, const StopRequest& stop) {
  // In real time nothing is known beforehand, as in a live run.
  const TracksEvidence evidence =
      o.as_recorded || realtime(o) ? TracksEvidence{} : examine_tracks(recording, settings, stop);
  std::ranges::move(mask_remarks(settings.frontend.mask, recording.cameras),
                    std::back_inserter(recording.remarks));
  std::ranges::move(remarks_of(evidence, settings), std::back_inserter(recording.remarks));
  start_from_measured(settings, evidence);
  mend(recording, settings.filter, evidence);
  if (is_in_state(settings.filter.calibrate_readout) && !has_rolling_shutter(recording)) {
    recording.remarks.push_back(
        "calibrate_readout has no effect: no camera has a rolling shutter; readout_time, of the "
        "calibration or as a setting, states one");
  }
  const bool from_truth = o.begin == "truth";
  const InertialSensors sensors = inertial_sensors(recording);
  const InertialRunSettings of_run = decided(settings, recording);
  PreparedEstimator prepared;
  prepared.map = prior_map(o, recording);
  const auto map = prepared.map ? prepared.map->map() : nullptr;
  prepared.estimator = make_estimator(
      of_run, sensors,
      from_truth ? std::optional(start_at_truth(recording, o.input)) : std::nullopt, map);
  prepared.frontend = settings.frontend;
  prepared.run.realtime = realtime(o);
  prepared.run.wrong_lens = evidence.has_wrong_lens();
  prepared.run.tracks = o.input.tracks;
  prepared.recorded.calibration_columns = calibration_columns(of_run.filter, recording.cameras);
  prepared.recorded.frames_per_estimate = frames_per_estimate(settings);
  if (from_truth) prepared.recorded.truth_chart = settings.filter.chart;
  if (map) prepared.recorded.prior_map = map_sketch(*map);
  prepared.known = known_json(settings, recording);
  prepared.summary = [settings, sensors, &recording](const RecordedRun& run) {
    return summary_json(run, settings, sensors, recording);
  };
  return prepared;
}

EstimatorPlan plan_inertial(const SessionOptions& o, Recording& recording) {
  check_inertial(o);
  InertialRunSettings settings = inertial_run_settings_from(o.settings);
  if (uses_maps(o)) settings.filter.recognise = Recognise::kAppearance;
  return [&o, &recording, settings](const StopRequest& stop) {
    return prepare(o, settings, recording, stop);
  };
}

void check_velocity(const SessionOptions& o) {
  if (uses_maps(o)) throw UsageError("--map and --save-map are for a recording with an IMU");
  check_level_is_auto(o.input.truth_options);
  if (!o.settings.estimator.is_filter() && !o.full_covariance.empty()) {
    throw UsageError("--full-covariance is not available for --estimator " + o.estimator);
  }
  if (realtime(o)) throw UsageError("--realtime is for a recording with an IMU");
  if (o.keep_images) throw UsageError("--keep-images is for a recording with an IMU");
  if (o.as_recorded) throw UsageError("--as-recorded is for a recording with an IMU");
}

void check_velocity(const SessionOptions& o, const VelocitySlamSettings& settings) {
  if (!o.trajectory.empty() && settings.mode != SlamMode::kMap) {
    throw UsageError(
        fmt::format("--trajectory is for --mode map, the mode is {}", name_of(settings.mode)));
  }
  if (!o.full_covariance.empty() && settings.map_memory > 0) {
    throw UsageError("--full-covariance needs all steps of the filter: expected map_memory=0");
  }
}

// Again, with settings of the reader: they depend on the kind of the run, which is known only now.
Recording read_again(const SessionOptions& o, const ReaderSettings& reader) {
  if (o.input.recording.empty()) {
    throw UsageError(
        "reader.* is for where a recording is read, and this one has been: expected its path, as "
        "in chasles.run(path, reader={...})");
  }
  RecordingInput input = o.input;
  input.reader.stale_pixels = reader.stale_pixels;
  input.reader.extrinsics = reader.extrinsics;
  return read_input(input);
}

PreparedEstimator prepare(const SessionOptions& o, VelocityCommandSettings settings,
                          Recording& recording) {
  const ClockCorrection clock = correct_clock(settings.filter, recording);
  if (!clock.remark.empty()) recording.remarks.push_back(clock.remark);
  PreparedEstimator prepared;
  prepared.recorded.dead_reckoning = dead_reckoning(recording);
  if (!o.trajectory.empty()) {
    follow(recording, read_tum(o.trajectory, recording.remarks));
    settings.filter.hold = VelocityHold::kZeroOrder;
  }
  const VelocitySensors sensors = velocity_sensors(recording, settings);
  prepared.estimator = make_estimator(settings, sensors);
  prepared.recorded.frames_per_estimate = frames_per_estimate(settings);
  prepared.known = known_json(settings, recording);
  prepared.summary = [settings, sensors, clock, &recording](const RecordedRun& run) {
    return summary_json(run, settings, sensors, clock.offset, recording);
  };
  return prepared;
}

EstimatorPlan plan_velocity(const SessionOptions& o, Recording& recording) {
  check_velocity(o);
  const VelocityCommandSettings settings = velocity_run_settings_from(o.settings);
  check_velocity(o, settings.filter);
  if (settings.reader != ReaderSettings{}) recording = read_again(o, settings.reader);
  return [&o, &recording, settings](const StopRequest& /*stop*/) {
    return prepare(o, settings, recording);
  };
}

}  // namespace

EstimatorPlan plan_estimator(const SessionOptions& o, Recording& recording) {
  return recording.velocities.empty() ? plan_inertial(o, recording) : plan_velocity(o, recording);
}

}  // namespace chasles
