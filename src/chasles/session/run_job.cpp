#include <algorithm>
#include <iterator>
#include <memory>
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
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/remarks.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/session/summary.hpp>
#include <chasles/session/truth_preparation.hpp>
#include <chasles/session/velocity_settings_io.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> realtime(const SessionOptions& o) {
  if (!o.realtime && !o.realtime_speed) return std::nullopt;
  return o.realtime_speed.value_or(1);
}

void check(const SessionOptions& o, const VelocitySlamSettings& settings) {
  if (!o.trajectory.empty() && settings.mode != SlamMode::kMap) {
    throw UsageError(
        fmt::format("--trajectory is for --mode map, the mode is {}", name_of(settings.mode)));
  }
}

// Adds remarks on the end of the run.
void add_remarks(const Run& run, const RunReport& report, std::size_t frames,
                 std::vector<std::string>& remarks) {
  if (report.in_smoothing) {
    remarks.push_back("interrupted during batch estimation: the results are those of the filter");
  } else if (report.interrupted) {
    remarks.push_back(fmt::format("interrupted after {} of {} frames: the results end there",
                                  run.states.size(), frames));
  } else if (!run.states.empty() && run.states.back().health == "lost") {
    remarks.push_back(fmt::format("the estimate was lost at frame {} of {}: the run ends there",
                                  run.states.size(), frames));
  }
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

// Estimator and options of a run of either kind, and its summary.
struct Prepared {
  std::unique_ptr<Estimator> estimator;
  std::unique_ptr<SharedMap> shared_map;
  RunRecordingOptions options;
  std::function<Json(const RecordedRun&)> summary;
};

// Examines the truth with the estimate, and applies what the options leave to that: an offset, a
// point on the body, and the tilt of a world that is not level, with what else is in that world.
void prepare_truth_of_run(const RecordingInput& input, Recording& recording, RecordedRun& result) {
  Run& run = result.run;
  if (run.truth.empty() || run.states.empty()) return;
  TruthReference reference{.name = "the estimate",
                           .poses = {},
                           .level = is_level(run),
                           .frames = known_frames(recording)};
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.R.allFinite() || !s.world_T_imu.p.allFinite()) continue;
    reference.poses.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  const TruthToPrepare how{.attitudes = recording.truth_attitudes,
                           .point_imu = recording.truth_point_imu,
                           .estimate_offset = is_offset_auto(input.truth_options),
                           .turn_to_level = is_level(run) && !recording.truth_level.value_or(true),
                           .pairing = run.pairing};
  const auto keep_remarks = [&](const PreparedTruth& prepared_truth) {
    for (const std::string& remark : prepared_truth.remarks) recording.remarks.push_back(remark);
    for (const TruthFinding& f : prepared_truth.findings) recording.remarks.push_back(sentence(f));
  };
  try {
    const PreparedTruth prepared_truth = prepare_truth(reference, how, run.truth);
    keep_remarks(prepared_truth);
    result.truth_attitudes = prepared_truth.attitudes;
    result.truth_findings = prepared_truth.findings;
    if (!prepared_truth.tilt) return;
    for (TrueLandmark& landmark : recording.true_landmarks) {
      landmark.p_world = prepared_truth.tilt->level_R_truth * landmark.p_world;
    }
    result.truth_tilt_deg = prepared_truth.tilt->degrees;
  } catch (const InputError& error) {
    if (how.estimate_offset) {
      recording.remarks.push_back(fmt::format("not evaluated: {}", error.what()));
      run.truth.clear();
      return;
    }
    // The evaluation reports why the truth cannot be compared; the findings may say more.
    keep_remarks({.findings = examine_truth(reference, run.truth,
                                            {.gap = run.pairing.longest_gap,
                                             .positions_only = !how.attitudes})
                                  .findings,
                  .tilt = {},
                  .remarks = {}});
  }
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

Prepared prepare(const SessionOptions& o, InertialRunSettings settings, Recording& recording,
                 const StopRequest& stop) {
  // In real time nothing is known beforehand, as in a live run.
  const TracksEvidence evidence =
      realtime(o) ? TracksEvidence{} : examine_tracks(recording, settings, stop);
  std::ranges::move(mask_remarks(settings.frontend.mask, recording.cameras),
                    std::back_inserter(recording.remarks));
  std::ranges::move(remarks_of(evidence, settings), std::back_inserter(recording.remarks));
  start_from_measured_offset(settings, evidence);
  const bool from_truth = o.begin == "truth";
  const InertialSensors sensors = inertial_sensors(recording);
  const InertialRunSettings of_run = decided(settings, recording);
  std::unique_ptr<SharedMap> shared;
  if (!o.map.empty()) shared = std::make_unique<SharedMap>(o.map);
  const auto map = shared ? shared->map() : nullptr;
  if (map &&
      std::ranges::find(map->sessions, recording.name, &MapSession::name) != map->sessions.end()) {
    spdlog::warn(
        "{} has a session of a recording named {}, as this one is: if it is the same, its "
        "information counts twice",
        o.map.string(), recording.name);
  }
  Prepared prepared;
  prepared.shared_map = std::move(shared);
  prepared.estimator = make_estimator(
      of_run, sensors,
      from_truth ? std::optional(start_at_truth(recording, o.input)) : std::nullopt, map);
  prepared.options.frontend = settings.frontend;
  prepared.options.run.realtime = realtime(o);
  prepared.options.run.wrong_lens = evidence.has_wrong_lens();
  prepared.options.run.tracks = o.input.tracks;
  if (map) prepared.options.prior_map = map_sketch(*map);
  if (settings.estimator.is_window()) {
    prepared.options.frames_per_estimate = settings.batch.frames_per_keyframe;
  }
  prepared.options.known = known_json(settings, recording);
  prepared.options.calibration_columns =
      calibration_columns(of_run.filter, recording.cameras.size());
  if (from_truth) prepared.options.truth_chart = settings.filter.chart;
  prepared.summary = [settings, sensors, &recording](const RecordedRun& run) {
    return summary_json(run, settings, sensors, recording);
  };
  return prepared;
}

void check_velocity(const SessionOptions& o) {
  if (uses_maps(o)) throw UsageError("--map and --save-map are for a recording with an IMU");
  check_level_is_auto(o.input.truth_options);
  if (!o.settings.estimator.is_filter() && !o.full_covariance.empty()) {
    throw UsageError("--full-covariance is not available for --estimator " + o.estimator);
  }
  if (realtime(o)) throw UsageError("--realtime is for a recording with an IMU");
  if (o.keep_images) throw UsageError("--keep-images is for a recording with an IMU");
}

Prepared prepare(const SessionOptions& o, VelocityCommandSettings settings, Recording& recording) {
  const ClockCorrection clock = correct_clock(settings.filter, recording);
  if (!clock.remark.empty()) recording.remarks.push_back(clock.remark);
  Prepared prepared;
  prepared.options.dead_reckoning = dead_reckoning(recording);
  if (!o.trajectory.empty()) {
    follow(recording, read_tum(o.trajectory, recording.remarks));
    settings.filter.hold = VelocityHold::kZeroOrder;
  }
  const VelocitySensors sensors = velocity_sensors(recording, settings);
  prepared.estimator = make_estimator(settings, sensors);
  if (settings.estimator.is_window()) {
    prepared.options.frames_per_estimate = settings.batch.frames_per_keyframe;
  }
  prepared.options.known = known_json(settings, recording);
  prepared.summary = [settings, sensors, clock, &recording](const RecordedRun& run) {
    return summary_json(run, settings, sensors, clock.offset, recording);
  };
  return prepared;
}

// Checks options and settings, before outputs and viewers exist. Returns the work that is left.
std::function<Prepared(const StopRequest&)> plan(const SessionOptions& o, Recording& recording) {
  if (recording.velocities.empty()) {
    check_inertial(o);
    InertialRunSettings settings = inertial_run_settings_from(o.settings);
    if (uses_maps(o)) settings.filter.recognise = Recognise::kAppearance;
    return [&o, &recording, settings](const StopRequest& stop) {
      return prepare(o, settings, recording, stop);
    };
  }
  check_velocity(o);
  const VelocityCommandSettings settings = velocity_run_settings_from(o.settings);
  check(o, settings.filter);
  if (!o.full_covariance.empty() && settings.filter.map_memory > 0) {
    throw UsageError("--full-covariance needs all steps of the filter: expected map_memory=0");
  }
  if (settings.reader != ReaderSettings{}) {  // known only now, because they depend on the kind
    if (o.input.recording.empty()) {
      throw UsageError(
          "reader.* is for where a recording is read, and this one has been: expected its path, as "
          "in chasles.run(path, reader={...})");
    }
    RecordingInput input = o.input;
    input.reader.stale_pixels = settings.reader.stale_pixels;
    input.reader.extrinsics = settings.reader.extrinsics;
    recording = read_input(input);
  }
  return [&o, &recording, settings](const StopRequest& /*stop*/) {
    return prepare(o, settings, recording);
  };
}

// As run_recording(). A run without an estimate ends with what a check of the recording finds.
RecordedRun run_or_diagnose(const Recording& recording, const Prepared& prepared,
                            const StopRequest& stop, SessionObserver& observer) {
  try {
    return run_recording(recording, *prepared.estimator, prepared.options, stop, observer);
  } catch (const Error& error) {
    if (error.code() != ExitCode::kNotInitialised) throw;
    throw Error(error.code(), fmt::format("{}; {}", error.what(),
                                          finding_of_check(recording, prepared.options.frontend)));
  }
}

}  // namespace

PlannedRun plan_run(const SessionOptions& o, Recording& recording) {
  return [&o, &recording, prepare_run = plan(o, recording)](const StopRequest& stop,
                                                            SessionObserver& observer) {
    Prepared prepared = prepare_run(stop);
    prepared.options.estimator = o.settings.estimator;
    prepared.options.run.threads = o.threads;
    prepared.options.quiet = o.quiet;
    prepared.options.keep_images = o.keep_images;
    prepared.options.truth_is_comparable =
        !is_offset_auto(o.input.truth_options) && recording.truth_attitudes;
    CompletedRun run{.result = run_or_diagnose(recording, prepared, stop, observer)};
    prepare_truth_of_run(o.input, recording, run.result);
    add_remarks(run.result.run, run.result.report, frame_count(recording), recording.remarks);
    run.summary = prepared.summary(run.result);
    if (!run.result.truth_findings.empty()) {
      run.summary["truth_findings"] = truth_findings_json(run.result.truth_findings);
    }
    if (run.result.report.interrupted) run.summary["interrupted"] = true;
    run.estimator = std::move(prepared.estimator);
    run.map = std::move(prepared.shared_map);
    return run;
  };
}

}  // namespace chasles
