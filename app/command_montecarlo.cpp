#include <algorithm>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/batch_list.hpp>
#include <chasles/session/interrupt.hpp>
#include <chasles/session/progress.hpp>

#include "filter_options.hpp"
#include "lab_report.hpp"
#include "lab_scene.hpp"
#include "options.hpp"
#include "print.hpp"
#include "scene_options.hpp"
#include "subcommands.hpp"
#include "trial_log.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;

struct MonteCarloOptions {
  SceneChoice scene;
  FilterOptions filters;
  std::uint64_t runs = 0, first = 0;
  int workers = 0;  ///< 0: one per core
  std::string shard;
  bool resume = false;
  std::vector<fs::path> merge;
  fs::path output;
  bool json = false, markdown = false, quiet = false;
};

std::vector<std::uint64_t> runs_of(const MonteCarloOptions& o) {
  const Shard shard = shard_from(o.shard);
  std::vector<std::uint64_t> runs;
  for (std::uint64_t i = shard.part - 1; i < o.runs; i += shard.parts) runs.push_back(o.first + i);
  return runs;
}

void check(const MonteCarloOptions& o) {
  if (!o.merge.empty()) {
    if (o.scene.name.empty() && o.runs == 0) return;
    throw UsageError("--merge takes folders alone: expected neither a SCENE nor --runs");
  }
  if (o.scene.name.empty()) {
    throw UsageError("SCENE is required: " + lab_scene_names());
  }
  if (o.runs == 0) throw UsageError("--runs is required: expected a whole number above 0");
  if (o.workers < 0) {
    throw UsageError(
        fmt::format("--workers: found {}, expected a whole number above 0", o.workers));
  }
}

/// Thrown out of the work at the first Ctrl-C.
struct Interrupted {};

int workers_of(const MonteCarloOptions& o) {
  return o.workers > 0 ? o.workers
                       : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

// Executes the runs, and keeps the lines of each. Returns false if interrupted.
bool work(const MonteCarloOptions& o, const LabScene& scene, const std::vector<std::uint64_t>& runs,
          TrialLog& log) {
  const Interrupt interrupt;
  Progress progress(runs.size(), o.quiet, "runs");
  std::size_t done = 0;
  try {
    scene.work(runs, workers_of(o), [&](std::span<const TrialRecord> records) {
      std::string lines;
      for (const TrialRecord& record : records) lines += to_line(record);
      log.add(records.front().run, lines);
      progress.show(++done);
      if (interrupt.requested() && done < runs.size()) throw Interrupted{};
    });
  } catch (const Interrupted&) {
    return false;
  }
  return true;
}

void print(const MonteCarloOptions& o, const TrialLog& log,
           std::span<const FilterSummary> summaries) {
  if (o.json) {
    app::print("{}\n", json_text(log.summary(), 2));
    return;
  }
  if (!o.markdown) {
    app::print("{}: {} runs, seed {}\n\n", log.summary().at("name").get<std::string>(),
               log.summary().at("runs").get<std::size_t>(),
               log.summary().at("seed").get<std::uint64_t>());
  }
  app::print("{}", tables(summaries, {}, o.markdown ? TableStyle::kMarkdown : TableStyle::kText));
  if (!o.markdown) app::print("\nstudy: {}\n", o.output.string());
}

int deliver(const MonteCarloOptions& o, TrialLog& log) {
  const std::vector<FilterSummary> summaries = log.finish();
  print(o, log, summaries);
  std::size_t runs = 0, diverged = 0;
  for (const FilterSummary& s : summaries) {
    runs += s.runs;
    diverged += s.diverged;
    if (s.diverged > 0) spdlog::warn("{}: {} of {} runs diverged", s.filter, s.diverged, s.runs);
  }
  return static_cast<int>(diverged == runs ? ExitCode::kDiverged : ExitCode::kOk);
}

int merge(const MonteCarloOptions& o) {
  TrialLog log = TrialLog::merged(o.merge, o.output);
  return deliver(o, log);
}

int execute(const MonteCarloOptions& o, const LabScene& scene) {
  const std::vector<std::uint64_t> asked = runs_of(o);
  TrialLog log(o.output, scene.plan, asked, o.resume);
  std::vector<std::uint64_t> missing;
  std::ranges::copy_if(asked, std::back_inserter(missing),
                       [&](std::uint64_t run) { return !log.has(run); });
  if (!work(o, scene, missing, log)) {
    spdlog::error("interrupted: {} of {} runs are done; --resume continues the study", log.runs(),
                  asked.size());
    return Interrupt::kExitCode;
  }
  return deliver(o, log);
}

int montecarlo(const MonteCarloOptions& o) {
  if (o.quiet) spdlog::set_level(spdlog::level::err);
  check(o);
  if (!o.merge.empty()) return merge(o);
  return execute(o, lab_scene(o.scene, o.filters));
}

void declare_study(CLI::App& parser, MonteCarloOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* type, const char* meaning) {
    return parser.add_option(name, value, meaning)->type_name(type)->group("Study");
  };
  add("--runs", o.runs, "N", "Number of runs");
  add("--first", o.first, "K", "Number of the first run (default: 0)");
  add("--workers", o.workers, "W", "Number of processes (default: one per core)");
  add("--shard", o.shard, "I/N", "Only the I-th of N parts of the runs, I from 1 to N");
  parser.add_flag("--resume", o.resume, "Continue the study in DIR, or start it if there is none")
      ->group("Study");
  add("--merge", o.merge, "DIR...", "Merge these parts of one study instead of executing runs");
}

void declare_output(CLI::App& parser, MonteCarloOptions& o) {
  parser.add_option("-o,--output", o.output, "Folder of the study")
      ->required()
      ->check(require_path)
      ->type_name("DIR")
      ->group("Output");
  CLI::Option* json = parser.add_flag("--json", o.json, "Print the summary as JSON");
  json->group("Output");
  parser.add_flag("--markdown", o.markdown, "Print the tables as Markdown")
      ->excludes(json)
      ->group("Output");
  parser.add_flag("--quiet", o.quiet, "No progress and no log, only errors")->group("Output");
}

}  // namespace

Action declare_montecarlo(CLI::App& parser) {
  const auto o = std::make_shared<MonteCarloOptions>();
  parser.add_option("SCENE", o->scene.name, lab_scene_names())->type_name("");
  declare_study(parser, *o);
  declare_scene(parser, o->scene);
  declare_filters(parser, o->filters);
  declare_output(parser, *o);
  parser.footer(lab_help());
  return [o] { return montecarlo(*o); };
}

}  // namespace chasles::app
