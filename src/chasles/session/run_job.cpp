#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/base/free_memory.hpp>
#include <chasles/pipeline/observer_list.hpp>
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/image_keeper.hpp>
#include <chasles/session/progress.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/session/track_release.hpp>
#include <chasles/session/truth_of_run.hpp>
#include <chasles/session/truth_preparation.hpp>

namespace chasles {
namespace {

// Ends the run where it is asked to.
class EndsOnRequest : public RunObserver {
 public:
  explicit EndsOnRequest(const StopRequest& stop) : stop_(stop) {}
  bool stop() override { return stop_(); }

 private:
  const StopRequest& stop_;
};

// What a terminal shows of the run: the progress bar, and images that cannot be read.
class OnTerminal : public RunObserver {
 public:
  OnTerminal(const RunRecorder& recorder, std::size_t frames, bool quiet)
      : recorder_(recorder), progress_(frames, quiet) {}

  // A camera may have no image that can be read, of thousands.
  void on_unreadable(const InputError& error) override {
    constexpr int kMostWarnings = 20;
    if (++unreadable_ > kMostWarnings) return;
    spdlog::warn("{}", error.what());
    if (unreadable_ == kMostWarnings) spdlog::warn("further unreadable images are only counted");
  }
  void on_progress(std::size_t frames, Time now) override {
    progress_.show(frames, recorder_.recorded_seconds(now));
  }

 private:
  const RunRecorder& recorder_;
  Progress progress_;
  int unreadable_ = 0;  // frames with an image that cannot be read
};

// What either kind of run has to be recorded with.
RunRecorder::Options recorder_options(const SessionOptions& o, const Recording& recording,
                                      const PreparedEstimator& prepared) {
  RunRecorder::Options options = prepared.recorded;
  options.has_stages = !o.settings.estimator.is_window();
  options.realtime = prepared.run.realtime;
  options.truth_is_comparable = !is_offset_auto(o.input.truth_options) && recording.truth_attitudes;
  return options;
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

// Whether an output is made by the estimator after the run.
bool needs_estimator(const SessionOptions& o) {
  return o.extend || !o.save_map.empty() || !o.full_covariance.empty();
}

}  // namespace

PreparedRun::PreparedRun(const SessionOptions& options, Recording& recording,
                         PreparedEstimator prepared, StopRequest stop)
    : options_(options),
      recording_(recording),
      prepared_(std::move(prepared)),
      stop_(std::move(stop)),
      recorder_(std::make_unique<RunRecorder>(recording, *prepared_.estimator,
                                              recorder_options(options, recording, prepared_))) {
  prepared_.run.threads = options.threads;
}

RecordedRun PreparedRun::record(RunObserver& viewer) {
  ImageKeeper keeper(recording_, options_.keep_images);
  OnTerminal terminal(*recorder_, frame_count(recording_), options_.quiet);
  EndsOnRequest end(stop_);
  TrackRelease release(recording_);
  ObserverList observers{*recorder_, keeper, terminal, end, viewer, release};
  RunReport report =
      chasles::run(recording_, *prepared_.estimator, prepared_.frontend, prepared_.run, observers);
  recording_.imu = std::vector<ImuSample>();  // as the tracks
  RecordedRun result = recorder_->finish(std::move(report));
  result.run.images = keeper.take();
  return result;
}

RecordedRun PreparedRun::record_or_diagnose(RunObserver& viewer) {
  try {
    return record(viewer);
  } catch (const Error& error) {
    if (error.code() != ExitCode::kNotInitialised) throw;
    throw Error(error.code(), fmt::format("{}; {}", error.what(),
                                          finding_of_check(recording_, prepared_.frontend)));
  }
}

CompletedRun PreparedRun::run(RunObserver& viewer) {
  CompletedRun run{.result = record_or_diagnose(viewer)};
  if (needs_estimator(options_)) run.estimator = std::move(prepared_.estimator);
  prepared_.estimator.reset();  // the evaluation needs memory, too
  return_free_memory();
  prepare_truth_of_run(options_.input.truth_options, recording_, run.result);
  add_remarks(run.result.run, run.result.report, frame_count(recording_), recording_.remarks);
  run.summary = prepared_.summary(run.result);
  if (!run.result.truth_findings.empty()) {
    run.summary["truth_findings"] = truth_findings_json(run.result.truth_findings);
  }
  add_truth_errors(options_.input.truth_options, run.result, run.summary);
  if (run.result.report.interrupted) run.summary["interrupted"] = true;
  if (const TracksPart& tracks = options_.input.tracks; tracks.part) {
    run.summary["tracks"] = {{"part", *tracks.part}, {"seed", tracks.seed}, {"rest", tracks.rest}};
  }
  run.map = std::move(prepared_.map);
  return run;
}

PlannedRun plan_run(const SessionOptions& o, Recording& recording) {
  return [&o, &recording, prepare = plan_estimator(o, recording)](const StopRequest& stop) {
    return PreparedRun(o, recording, prepare(stop), stop);
  };
}

}  // namespace chasles
