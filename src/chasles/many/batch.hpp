#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/many/assessed_run.hpp>
#include <chasles/many/batch_list.hpp>
#include <chasles/many/bounded_processes.hpp>

namespace chasles {

/// Many recordings, each run in a process of its own and assessed (docs/many.md).
struct BatchOptions {
  std::vector<BatchItem> items;  ///< with their names
  AssessedRunOptions run;
  /// The item that runs first, and saves the map in which the others find their places.
  std::optional<std::size_t> map_from;
  ProcessBounds bounds;
  int jobs = 1;  ///< processes at a time
  Shard shard;   ///< the part of the items that is run
  bool resume = false;
  /// Kinds of reasons: recordings whose record has one of them run again.
  std::vector<std::string> retry;
  bool collect = false;  ///< runs nothing: finishes a batch of which all recordings have records
  std::filesystem::path output;
  std::filesystem::path against;  ///< folder of an earlier batch; empty: none
};

/// What follows a batch, as recordings end.
struct BatchObserver {
  /// Before the first process: how many recordings will run.
  std::function<void(std::size_t recordings)> begins = [](std::size_t) {};
  /// `record`: without the sketch of the path. `timing`: attempts, seconds_wall, seconds_cpu,
  /// peak_mb.
  std::function<void(const nlohmann::ordered_json& record, const nlohmann::ordered_json& timing)>
      ended;
  std::function<bool()> stop;  ///< whether to end early
  /// With `collect`, of each item in turn: its record without the sketch, or name, recording and
  /// the verdict null.
  std::function<void(const nlohmann::ordered_json& record)> listed = {};
};

/// How a batch ended.
struct BatchEnd {
  bool interrupted = false;
  std::size_t done = 0, total = 0;  ///< recordings of this part, those of earlier calls included
  Verdict worst = Verdict::kUse;    ///< of the recordings that are done
  /// summary.json and the difference to the earlier batch, when all recordings of all parts have
  /// their records; else null.
  nlohmann::ordered_json summary, difference;
};

/// Runs what has no record yet. Throws UsageError for settings that no run can use, as BatchFolder,
/// and if a run folder cannot be written; InputError where the map of `map_from` cannot be made, as
/// read_verdicts().
BatchEnd run_batch(const BatchOptions& options, const BatchObserver& observer);

}  // namespace chasles
