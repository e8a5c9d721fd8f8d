#include <algorithm>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/batch.hpp>
#include <chasles/many/batch_difference.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/progress.hpp>

#include "method_options.hpp"
#include "options.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct BatchCommandOptions {
  std::vector<fs::path> recordings;
  fs::path list, map_from;
  std::optional<double> coverage, sigma, drift, nis, seconds, megabytes;
  std::string shard;
  std::optional<int> jobs;  ///< none: one per core
  bool no_check = false, quiet = false;
  BatchOptions batch;
};

// The recordings of the arguments, then those of the list; and that of the map before all.
void gather_items(BatchCommandOptions& o) {
  std::vector<BatchItem>& items = o.batch.items;
  for (const fs::path& recording : o.recordings) items.push_back({.recording = recording});
  if (!o.list.empty()) {
    std::ranges::move(read_batch_list(o.list), std::back_inserter(items));
  }
  if (!o.map_from.empty()) {
    if (!o.batch.run.session.map.empty() || !o.shard.empty()) {
      throw UsageError(fmt::format(
          "--map-from excludes {}: `chasles run RECORDING --save-map MAP`, then --map MAP",
          o.shard.empty() ? "--map" : "--shard"));
    }
    const auto normal = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
    const auto is_it = [&](const BatchItem& item) {
      return normal(item.recording) == normal(o.map_from);
    };
    auto found = std::ranges::find_if(items, is_it);
    if (found == items.end()) found = items.insert(items.begin(), {.recording = o.map_from});
    o.batch.map_from = static_cast<std::size_t>(found - items.begin());
  }
  if (items.empty())
    throw UsageError("found no recording: expected RECORDING... or --manifest FILE");
  name_items(items);
}

void check_span(const RecordingInput& input) {
  if (!input.start || !input.stop || *input.start < *input.stop) return;
  throw UsageError(
      fmt::format("--stop: found {}, expected more than --start {}", *input.stop, *input.start));
}

void check_reasons(const std::vector<std::string>& reasons) {
  for (const std::string& reason : reasons) {
    const auto is_it = [&](const ReasonKind& kind) { return reason == kind.name; };
    if (std::ranges::none_of(reason_kinds(), is_it)) {
      throw UsageError(fmt::format("--retry: unknown reason '{}' (--help lists them)", reason));
    }
  }
}

void complete(BatchCommandOptions& o) {
  BatchOptions& batch = o.batch;
  SessionOptions& session = batch.run.session;
  const bool in_map = !session.map.empty() || !o.map_from.empty();
  if (session.estimator.empty()) session.estimator = in_map ? "filter" : "batch";
  session.settings.estimator = estimator_choice(session.estimator, "--estimator");
  batch.shard = shard_from(o.shard);
  gather_items(o);
  if (o.jobs && *o.jobs < 1) {
    throw UsageError(fmt::format("--jobs: found {}, expected a whole number above 0", *o.jobs));
  }
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  batch.jobs = o.jobs.value_or(static_cast<int>(cores));
  // Whole recordings are the better unit of work; the results are the same bytes.
  session.threads = 1;
  // Its plan may be there, or is made for parts that run elsewhere.
  batch.resume |= batch.collect;
  check_span(session.input);
  check_reasons(batch.retry);
  batch.run.check = !o.no_check;
  VerdictLimits& limits = batch.run.limits;
  limits.least_coverage = o.coverage.value_or(limits.least_coverage);
  limits.most_sigma = o.sigma.value_or(limits.most_sigma);
  limits.most_drift = o.drift.value_or(limits.most_drift);
  limits.most_nis = o.nis.value_or(limits.most_nis);
  ProcessBounds& bounds = batch.bounds;
  bounds.seconds_per_minute = o.seconds.value_or(bounds.seconds_per_minute);
  bounds.megabytes_per_minute = o.megabytes.value_or(bounds.megabytes_per_minute);
}

int exit_code(const BatchCommandOptions& o, const BatchEnd& end) {
  if (end.interrupted) return Interrupt::kExitCode;
  if (o.batch.collect && end.done < end.total) return static_cast<int>(ExitCode::kNotInitialised);
  switch (end.worst) {
    case Verdict::kUse:
      return static_cast<int>(ExitCode::kOk);
    case Verdict::kCheck:
      return static_cast<int>(ExitCode::kThresholdMissed);
    case Verdict::kNo:
      break;
  }
  return static_cast<int>(ExitCode::kBadInput);
}

void print_end(const BatchCommandOptions& o, const BatchEnd& end) {
  if (end.interrupted) {
    spdlog::error("interrupted: {} of {} recordings are done; --resume continues the batch",
                  end.done, end.total);
    return;
  }
  if (o.quiet) return;
  if (!end.difference.is_null()) note("{}", difference_text(end.difference));
  if (end.summary.is_null()) {
    note("{} of {} recordings of this part are done; the batch is not complete yet\n", end.done,
         end.total);
    return;
  }
  const Json& verdicts = end.summary.at("verdicts");
  note("{} recordings: {} use, {} check, {} no\npage: {}\n", end.done,
       verdicts.at("use").get<int>(), verdicts.at("check").get<int>(), verdicts.at("no").get<int>(),
       (o.batch.output / "page.html").string());
}

int batch_command(BatchCommandOptions o) {
  spdlog::set_level(spdlog::level::err);
  complete(o);
  const Interrupt interrupt;
  std::optional<Progress> progress;
  std::size_t done = 0;
  double seconds = 0;
  const auto begins = [&](std::size_t recordings) {
    progress.emplace(recordings, o.quiet, "recordings");
    progress->show(0);
  };
  const auto ended = [&](Json record, const Json& timing) {
    const auto recorded = record.find("recorded_seconds");
    if (recorded != record.end() && recorded->is_number()) seconds += recorded->get<double>();
    record.update(timing);
    app::print("{}\n", json_text(record));
    flush_stdout();
    progress->show(++done, seconds);
  };
  const auto listed = [](const Json& record) { app::print("{}\n", json_text(record)); };
  const BatchEnd end = run_batch(o.batch, {.begins = begins,
                                           .ended = ended,
                                           .stop = [&] { return interrupt.requested(); },
                                           .listed = listed});
  progress.reset();
  print_end(o, end);
  return exit_code(o, end);
}

std::string reasons_help() {
  std::string text = "Reasons, and the best verdict that each allows:\n";
  for (const ReasonKind& kind : reason_kinds()) {
    text += fmt::format("  {:<16} {:<6} {}\n", kind.name, name_of(kind.verdict), kind.meaning);
  }
  return text +
         "\nExit codes besides those of all commands: 0 all recordings have the verdict use,\n"
         "5 the worst is check, 2 the worst is no.";
}

void declare_input(CLI::App& parser, BatchCommandOptions& o) {
  parser.add_option("RECORDING", o.recordings, "Recordings, as those of `chasles run`")
      ->type_name("");
  RecordingInput& input = o.batch.run.session.input;
  const auto add = [&](const char* name, auto& value, const char* type, const char* meaning) {
    return parser.add_option(name, value, meaning)->type_name(type)->group("Input");
  };
  add("--manifest", o.list, "FILE",
      "More recordings: a path on each line, or a JSON object with its own name, truth, cameras, "
      "start, stop and set (docs/many.md)")
      ->check(require_path);
  add("--cameras", input.cameras, "mono|stereo", "As of `chasles run`");
  add_number(parser, "--start", input.start, "S", "Leave out each recording before this second", 0)
      ->group("Input");
  add_number(parser, "--stop", input.stop, "S", "Leave out each recording after this second", 0)
      ->group("Input");
}

void declare_map(CLI::App& parser, BatchCommandOptions& o) {
  parser
      .add_option("--map", o.batch.run.session.map,
                  "Find the place of each recording in this map, and give its poses there")
      ->type_name("MAP")
      ->check(require_path)
      ->group("Map");
  parser
      .add_option("--map-from", o.map_from,
                  "Run this recording first, and take the map that it makes")
      ->type_name("RECORDING")
      ->check(require_path)
      ->group("Map");
}

void declare_verdicts(CLI::App& parser, BatchCommandOptions& o) {
  const VerdictLimits limits;
  const auto add = [&](const char* name, std::optional<double>& value, const char* unit,
                       const std::string& meaning, double by_default, double most = 1e9) {
    add_number(parser, name, value, unit, fmt::format("{} (default: {})", meaning, by_default), 0,
               most)
        ->group("Verdicts");
  };
  add("--least-coverage", o.coverage, "SHARE", "Frames with an estimate, 0 to 1",
      limits.least_coverage, 1);
  add("--most-sigma", o.sigma, "M", "Standard deviation of a position", limits.most_sigma);
  add("--most-drift", o.drift, "M",
      "The same for each 100 m of path; of long paths it counts instead", limits.most_drift);
  add("--most-nis", o.nis, "X", "Mean NIS for each degree of freedom", limits.most_nis);
  parser
      .add_flag("--no-check", o.no_check,
                "Do not examine the recordings as `chasles check` does: faster, and wrong clocks, "
                "axes and lenses may stay unseen")
      ->group("Verdicts");
}

void declare_processes(CLI::App& parser, BatchCommandOptions& o) {
  const ProcessBounds bounds;
  parser.add_option("--jobs", o.jobs, "Recordings at a time (default: one per core)")
      ->type_name("N")
      ->group("Processes");
  parser
      .add_option("--shard", o.shard, "Only the I-th of N parts of the recordings, I from 1 to N")
      ->type_name("I/N")
      ->group("Processes");
  parser
      .add_flag("--resume", o.batch.resume,
                "Continue the batch in DIR, or start it if there is none")
      ->group("Processes");
  parser
      .add_option("--retry", o.batch.retry,
                  "With --resume: run again what has this reason; may be repeated")
      ->type_name("REASON")
      ->allow_extra_args(false)
      ->group("Processes");
  parser
      .add_flag("--collect", o.batch.collect,
                "Run nothing: check the options, print the record of each recording or that it has "
                "none, and write the page if all have one, else end with exit code 3")
      ->group("Processes");
  const auto add = [&](const char* name, std::optional<double>& value, const char* unit,
                       const char* what, double by_default) {
    add_number(parser, name, value, unit,
               fmt::format("{} of a run for each minute of its recording, and of {} minutes at "
                           "least (default: {})",
                           what, ProcessBounds::kLeastMinutes, by_default),
               1e-3)
        ->group("Processes");
  };
  add("--seconds-per-minute", o.seconds, "S", "Most processor time", bounds.seconds_per_minute);
  add("--megabytes-per-minute", o.megabytes, "MB", "Most memory", bounds.megabytes_per_minute);
}

void declare_output(CLI::App& parser, BatchCommandOptions& o) {
  parser.add_option("-o,--output", o.batch.output, "Folder of the batch")
      ->required()
      ->check(require_path)
      ->type_name("DIR")
      ->group("Output");
  parser
      .add_option("--against", o.batch.against,
                  "Folder of an earlier batch: print what became better or worse since")
      ->check(require_path)
      ->type_name("DIR")
      ->group("Output");
  parser.add_flag("--quiet", o.quiet, "Only the line of each recording, and errors")
      ->group("Output");
}

}  // namespace

Action declare_batch(CLI::App& parser) {
  const auto o = std::make_shared<BatchCommandOptions>();
  declare_input(parser, *o);
  // Whose covariance holds best; a map needs the filter.
  o->batch.run.session.estimator = "";
  declare_method(parser, o->batch.run.session, "batch, and with a map filter");
  declare_map(parser, *o);
  declare_verdicts(parser, *o);
  declare_processes(parser, *o);
  declare_output(parser, *o);
  parser.footer(method_help() + "\n" + reasons_help());
  return [o] { return batch_command(*o); };
}

}  // namespace chasles::app
