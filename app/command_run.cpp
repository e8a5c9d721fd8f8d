#include <charconv>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/data/readers.hpp>
#include <chasles/data/run.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/data/utf8.hpp>
#include <chasles/error.hpp>
#include <chasles/filter/error_chart.hpp>

#include "batch_report.hpp"
#include "drive.hpp"
#include "estimator.hpp"
#include "filter_options.hpp"
#include "full_covariance.hpp"
#include "image_keeper.hpp"
#include "inertial_drive.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "run_input.hpp"
#include "run_settings.hpp"
#include "stopwatch.hpp"
#include "subcommands.hpp"
#include "summary.hpp"
#include "thresholds.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

struct RunOptions {
  RunInput input;
  SettingSources settings;
  std::filesystem::path trajectory, output, full_covariance;
  std::string begin = "auto", estimator = "filter";
  int threads = 3;
  bool realtime = false;
  std::optional<double> realtime_speed;
  bool json = false, quiet = false;
  LiveOptions live;
  std::optional<int> keep_images;
  std::vector<Threshold> thresholds = run_thresholds();
};

std::string settings_help() {
  VelocitySlamSettings defaults;
  return "Settings, for --set and --config (auto: measured from the recording):\n" +
         help_text(setting_list(defaults)) + "\n" + filter_settings_help() + "\n" +
         inertial_run_settings_help();
}

std::string chart_help() {
  std::string text = "Error chart:";
  for (const ErrorChart& chart : error_charts()) text += fmt::format(" {}", chart.name);
  return text;
}

void declare_input(CLI::App& parser, RunOptions& o) {
  parser
      .add_option("RECORDING", o.input.recording,
                  "ECE276A .npz, STARS .mat, AprilGrid folder, or a recording folder")
      ->required()
      ->type_name("");
  const auto add = [&](const char* name, std::filesystem::path& path, const char* meaning) {
    parser.add_option(name, path, meaning)->type_name("FILE")->group("Input");
  };
  add("--truth", o.input.truth,
      "True trajectory: TUM, or a recording that has it (default: the recording's own)");
  add("--trajectory", o.trajectory, "Trajectory (TUM) to map along, with --mode map");
  parser.add_option("--cameras", o.input.cameras, "mono or stereo (default: all that there are)")
      ->type_name("NAME")
      ->group("Input");
  parser.add_flag("--backwards", o.input.backwards, "Play the recording from its end")
      ->group("Input");
  add_number(parser, "--start", o.input.start, "S", "Leave out the recording before this second", 0)
      ->group("Input");
  add_number(parser, "--stop", o.input.stop, "S", "Leave out the recording after this second", 0)
      ->group("Input");
  add_number(parser, "--tracks", o.input.tracks.part, "PART",
             "Use a random part of the tracks, from 0 to 1: how much of a run is chance of which "
             "points were tracked (default: all)",
             0, 1)
      ->group("Input");
  const auto read_seed = [&seed = o.input.tracks.seed](const std::string& text) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
    if (error == std::errc() && end == text.data() + text.size()) return;
    throw UsageError("--tracks-seed: found " + text + ", expected a whole number from 0 on");
  };
  parser
      .add_option_function<std::string>("--tracks-seed", read_seed,
                                        "Chooses that part (default: 1)")
      ->type_name("N")
      ->group("Input");
}

void declare_method(CLI::App& parser, RunOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* type, const std::string& text) {
    return parser.add_option(name, value, text)->type_name(type)->group("Method");
  };
  add("--mode", o.settings.mode, "NAME",
      "localize: velocities alone; map: along a given trajectory; slam: both at once (default)");
  add("--chart", o.settings.chart, "NAME", chart_help());
  add("--config", o.settings.config, "FILE", "Settings from a YAML file, `key: value` a line");
  add("--begin", o.begin, "NAME",
      "auto: an inertial run finds its start, at rest or in motion (default); truth: it begins at "
      "the true state");
  add("--estimator", o.estimator, "NAME",
      "filter (default); batch: the most probable motion given all of a recording, from the "
      "filter's run on (docs/batch.md); window:N: of the last N frames, with every frame, given "
      "all until then (docs/window.md)");
  add("--threads", o.threads, "N",
      "3 (default): images are read, and followed, on threads of their own, ahead of the filter; "
      "2: followed; 1: neither; the same bytes")
      ->check(CLI::Range(1, 3));
  add("--set", o.settings.sets, "KEY=VALUE", "One setting; may be repeated, the last one counts")
      ->allow_extra_args(false);
}

void declare_realtime(CLI::App& parser, RunOptions& o) {
  parser
      .add_flag("--realtime", o.realtime,
                "Play the recording at its own speed (IMU recordings); frames that the run does "
                "not keep up with are dropped and counted: results depend on the machine")
      ->group("Method");
  add_number(parser, "--realtime-speed", o.realtime_speed, "X",
             "The same at so many times its speed", 0.001, 1e6)
      ->group("Method");
}

std::optional<double> realtime(const RunOptions& o) {
  if (!o.realtime && !o.realtime_speed) return std::nullopt;
  return o.realtime_speed.value_or(1);
}

void declare_output(CLI::App& parser, RunOptions& o) {
  parser
      .add_option("-o,--output", o.output,
                  "Folder for the run (default: only the summary is printed)")
      ->type_name("RUN")
      ->group("Output");
  parser
      .add_option("--full-covariance", o.full_covariance,
                  "Covariance of the whole map, all with all, as .npy (may take gigabytes)")
      ->type_name("FILE")
      ->group("Output");
  declare_keep_images(parser, o.keep_images);
  declare_live(parser, o.live);
  parser.add_flag("--json", o.json, "Print the summary as JSON")->group("Output");
  parser.add_flag("--quiet", o.quiet, "No progress and no log, only errors")->group("Output");
}

void check(const RunOptions& o, const VelocitySlamSettings& settings) {
  if (!o.trajectory.empty() && settings.mode != SlamMode::kMap) {
    throw UsageError(
        fmt::format("--trajectory is for --mode map, the mode is {}", name_of(settings.mode)));
  }
}

void announce(const RunOptions& o, const Recording& recording) {
  spdlog::info("{}: {} frames, {} velocities, {} IMU samples", recording.name,
               frame_count(recording), recording.velocities.size(), recording.imu.size());
  const Threshold* threshold = needs_truth(o.thresholds);
  if (threshold && recording.truth.empty()) {
    throw UsageError(fmt::format("{}: {} has no true trajectory; give one with --truth",
                                 threshold->option, recording.name));
  }
}

// What the run itself has to say, for summary.json and the reader.
void add_remarks(const Run& run, bool interrupted, std::size_t frames,
                 std::vector<std::string>& remarks) {
  if (interrupted) {
    remarks.push_back(
        fmt::format("interrupted after {} of {} frames: this is what was estimated until then",
                    run.states.size(), frames));
  } else if (!run.states.empty() && run.states.back().health == "lost") {
    remarks.push_back(fmt::format("the estimate was lost at frame {} of {}: the run ends there",
                                  run.states.size(), frames));
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

void print(const RunOptions& o, const Json& figures) {
  if (o.json) {
    fmt::print("{}\n", json_text(figures, 2));
    return;
  }
  fmt::print("{}", summary_text(figures));
  if (const auto found = figures.find("realtime"); found != figures.end()) {
    fmt::print("{}", realtime_text(*found));
  }
  if (!o.output.empty()) fmt::print("\nrun folder: {}\n", o.output.string());
}

int exit_code(const RunOptions& o, const Run& run, bool interrupted, const Json& figures) {
  if (figures.at("health") == "lost") {
    spdlog::error("the estimate was lost: after {} frames it is no longer one to believe",
                  run.states.size());
    return static_cast<int>(ExitCode::kDiverged);
  }
  if (interrupted) return Interrupt::kExitCode;
  const std::vector<std::string> sentences = missed(o.thresholds, figures);
  for (const std::string& sentence : sentences) spdlog::error("missed: {}", sentence);
  return static_cast<int>(sentences.empty() ? ExitCode::kOk : ExitCode::kThresholdMissed);
}

// Whatever can be found out before an hour of work is lost.
void prepare_outputs(const RunOptions& o) {
  if (!o.output.empty()) prepare_output(o.output);
  if (!o.full_covariance.empty()) check_full_covariance(o.full_covariance);
}

Drive estimate(const RunOptions& o, DriveRunSettings& settings, Recording& recording,
               const Interrupt& interrupt, LiveView& live) {
  const double time_offset = correct_clock(settings.filter, recording);
  Trajectory velocities_alone = dead_reckoning(recording);
  if (!o.trajectory.empty()) {
    follow(recording, read_tum(o.trajectory));
    settings.filter.hold = VelocityHold::kZeroOrder;
  }
  const Estimator estimator = estimator_from("--estimator", o.estimator);
  Drive result = estimator.window > 0
                     ? slide(recording, settings.filter, settings.batch, estimator.window,
                             interrupt, o.quiet, std::move(velocities_alone), live)
                     : drive(recording, settings.filter, interrupt, o.quiet,
                             std::move(velocities_alone), live);
  if (estimator.batch && !result.interrupted) {
    live.smoothing();
    smooth(recording, settings.filter, settings.batch, result);
  }
  result.time_offset = time_offset;
  add_remarks(result.run, result.interrupted, recording.frames.size(), recording.remarks);
  return result;
}

// Writes what there is to write, and returns all figures.
Json deliver(const RunOptions& o, const Drive& result, const Json& summary, const Stopwatch& wall) {
  if (!o.output.empty()) write_run(result.run, summary, o.output);
  Json timing =
      timing_json(summary.at("recorded_seconds").get<double>(), wall.seconds(), cpu_seconds());
  if (result.batch) append_timing(*result.batch, timing);
  if (result.window) append_timing(*result.window, timing);
  if (!o.output.empty()) write_file(o.output / "timing.json", json_text(timing, 2) + "\n");
  if (!o.full_covariance.empty()) {
    write_full_covariance(*result.slam, result.run.landmarks, o.full_covariance);
  }
  return with_timing(summary, timing);
}

// What the work returns; where it throws, viewers are told why.
template <typename Work>
auto telling_why_not(LiveView& live, const Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    live.fail(error.what());
    throw;
  }
}

// A recording with IMU samples instead of body velocities.
int run_inertial(const RunOptions& o, Recording& recording, const Interrupt& interrupt,
                 const Stopwatch& wall) {
  if (!o.settings.mode.empty() && o.settings.mode != "slam") {
    throw UsageError("--mode: a recording with an IMU is run with slam alone");
  }
  if (!o.full_covariance.empty()) {
    throw UsageError("--full-covariance is not kept of a recording with an IMU");
  }
  if (o.begin != "auto" && o.begin != "truth") {
    throw UsageError(fmt::format("--begin: found '{}', expected auto or truth", o.begin));
  }
  const Estimator estimator = estimator_from("--estimator", o.estimator);
  if (!estimator.filter() && realtime(o)) {
    throw UsageError("--realtime is for the filter, not for --estimator " + o.estimator);
  }
  const InertialRunSettings settings = inertial_run_settings_from(o.settings);
  prepare_outputs(o);
  LiveView live(o.live, interrupt, o.output);
  InertialDrive result = telling_why_not(live, [&] {
    return drive(recording, settings,
                 {.from_truth = o.begin == "truth",
                  .threads = o.threads,
                  .quiet = o.quiet,
                  .realtime = realtime(o),
                  .estimator = estimator,
                  .keep_images = o.keep_images,
                  .tracks = o.input.tracks},
                 interrupt, live);
  });
  add_remarks(result.run, result.interrupted, frame_count(recording), recording.remarks);
  const Json summary = summary_json(result, settings, recording);
  if (!o.output.empty()) write_run(result.run, summary, o.output);
  const Json timing = timing_json(result, timing_json(summary.at("recorded_seconds").get<double>(),
                                                      wall.seconds(), cpu_seconds()));
  if (!o.output.empty()) write_file(o.output / "timing.json", json_text(timing, 2) + "\n");
  const Json figures = with_timing(summary, timing);
  print(o, figures);
  live.finish(result.run, json_text(figures), result.interrupted);
  return exit_code(o, result.run, result.interrupted, figures);
}

int run(const RunOptions& o) {
  const Stopwatch wall;
  if (o.quiet) spdlog::set_level(spdlog::level::err);
  const Estimator estimator = estimator_from("--estimator", o.estimator);
  if (o.keep_images && o.output.empty() && !o.live.wanted) {
    throw UsageError("--keep-images needs -o RUN, to have a place for them");
  }
  Recording recording = read_input(o.input);
  const Interrupt interrupt;  // before anybody is told that it goes on
  announce(o, recording);
  if (recording.velocities.empty()) return run_inertial(o, recording, interrupt, wall);
  if (!estimator.filter() && !o.full_covariance.empty()) {
    throw UsageError("--full-covariance is not kept of --estimator " + o.estimator);
  }
  if (realtime(o)) throw UsageError("--realtime is for a recording with an IMU");
  if (o.keep_images) throw UsageError("--keep-images is for a recording with an IMU");
  DriveRunSettings settings = settings_from(o.settings);
  check(o, settings.filter);
  prepare_outputs(o);
  LiveView live(o.live, interrupt, o.output);
  const Drive result =
      telling_why_not(live, [&] { return estimate(o, settings, recording, interrupt, live); });
  const Json summary = summary_json(result, settings, recording);
  const Json figures = deliver(o, result, summary, wall);
  print(o, figures);
  live.finish(result.run, json_text(figures), result.interrupted);
  return exit_code(o, result.run, result.interrupted, figures);
}

}  // namespace

Action declare_run(CLI::App& parser) {
  const auto options = std::make_shared<RunOptions>();
  declare_input(parser, *options);
  declare_method(parser, *options);
  declare_realtime(parser, *options);
  declare_output(parser, *options);
  add_options(parser, options->thresholds);
  parser.footer(settings_help());
  return [options] { return run(*options); };
}

}  // namespace chasles::app
