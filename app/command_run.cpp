#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/base/stopwatch.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/full_covariance.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/map_output.hpp>
#include <chasles/session/output_folder.hpp>
#include <chasles/session/recording_input.hpp>
#include <chasles/session/remarks.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/session/summary.hpp>

#include "live_view.hpp"
#include "print.hpp"
#include "run_command_options.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

void announce(const RunCommandOptions& o, const Recording& recording) {
  spdlog::info("{}: {} frames, {} velocities, {} IMU samples", recording.name,
               frame_count(recording), recording.velocities.size(), recording.imu.size());
  const Threshold* threshold = needs_truth(o.thresholds);
  if (threshold && recording.truth.empty()) {
    throw UsageError(fmt::format("{}: {} has no true trajectory; give one with --truth",
                                 threshold->option, recording.name));
  }
}

Json with_timing(const Json& summary, const Json& timing) {
  Json all = Json::object();
  for (const auto& [key, value] : summary.items()) {
    if (key == "settings") all.update(timing);
    all[key] = value;
  }
  return all;
}

void print(const RunCommandOptions& o, const Json& figures) {
  if (o.json) {
    app::print("{}\n", json_text(figures, 2));
    return;
  }
  app::print("{}", summary_text(figures));
  if (const auto found = figures.find("realtime"); found != figures.end()) {
    app::print("{}", realtime_text(*found));
  }
  if (!o.output.empty()) app::print("\nrun folder: {}\n", o.output.string());
}

int exit_code(const RunCommandOptions& o, const Run& run, bool interrupted,
              const std::string& no_map, const Json& figures) {
  if (figures.at("health") == "lost") {
    spdlog::error("the estimate was lost: after {} frames it is no longer valid",
                  run.states.size());
    return static_cast<int>(ExitCode::kDiverged);
  }
  if (interrupted) return Interrupt::kExitCode;
  if (!no_map.empty()) return static_cast<int>(ExitCode::kNotInitialised);
  const std::vector<std::string> sentences = missed(o.thresholds, figures);
  for (const std::string& sentence : sentences) spdlog::error("missed: {}", sentence);
  return static_cast<int>(sentences.empty() ? ExitCode::kOk : ExitCode::kThresholdMissed);
}

// Finds errors of the outputs before the run.
void prepare_outputs(const RunCommandOptions& o) {
  if (!o.output.empty()) prepare_output(o.output);
  if (!o.full_covariance.empty()) check_full_covariance(o.full_covariance);
  check_map_output(map_target(o));
}

// Writes the outputs and returns all figures.
Json deliver(const RunCommandOptions& o, const CompletedRun& run, const Stopwatch& wall) {
  Json summary = run.summary, timing;
  const auto take_time = [&] {
    timing = timing_json(run.result, summary.at("recorded_seconds").get<double>(), wall.seconds(),
                         process_seconds());
    return json_text(timing, 2) + "\n";
  };
  if (o.output.empty()) {
    take_time();
  } else {
    summary = write_run(run.result.run, summary, o.output, take_time);
  }
  if (!o.full_covariance.empty()) {
    write_full_covariance(*filter_with_joint_map(*run.estimator), run.estimator->state_names(),
                          run.result.run.landmarks, o.full_covariance);
  }
  return with_timing(summary, timing);
}

// Returns the result of `work`. If it throws, sends the reason to viewers.
template <typename Work>
auto reporting_failure(LiveView& live, const Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    live.fail(error.what());
    throw;
  }
}

int run_command(RunCommandOptions o) {
  const Stopwatch wall;
  if (o.quiet) spdlog::set_level(spdlog::level::err);
  o.settings.estimator = estimator_choice(o.estimator, "--estimator");
  if (o.keep_images && o.output.empty() && !o.live.wanted) {
    throw UsageError("--keep-images needs -o RUN or --live");
  }
  reject_output_into(o.output, o.input.recording);
  Recording recording = read_input(o.input);
  const RemarksOnError remarks(recording);
  const Interrupt interrupt(
      Interrupt::kPatienceOfRun);  // before the log shows that the run has started
  announce(o, recording);
  const PlannedRun planned = plan_run(o, recording);
  prepare_outputs(o);
  LiveView live(
      o.live, [&] { interrupt.request(); }, o.output);
  const CompletedRun run = reporting_failure(live, [&] {
    PreparedRun prepared = planned([&] { return interrupt.requested(); });
    live.begin(prepared.recorder(), prepared.known(), recording);
    return prepared.run(live);
  });
  const bool interrupted = run.result.report.interrupted;
  const Json figures = deliver(o, run, wall);
  print(o, figures);
  live.finish(run.result.run, json_text(figures), interrupted);
  const MapOutcome map = save_map(o, recording, run);
  if (!map.saved.empty() && !o.quiet && !o.json) app::print("map: {}\n", map.saved);
  if (!map.not_saved.empty()) spdlog::error("{}", map.not_saved);
  return exit_code(o, run.result.run, interrupted, map.not_saved, figures);
}

}  // namespace

Action declare_run(CLI::App& parser) {
  const auto options = std::make_shared<RunCommandOptions>();
  declare_run_options(parser, *options);
  return [options] { return run_command(*options); };
}

}  // namespace chasles::app
