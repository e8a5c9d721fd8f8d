#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/many/batch_list.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles {

/// The folder of a batch (docs/many.md): plan.json; of each recording runs/NAME, its record
/// verdicts/NAME.json and timing/NAME.json; of a complete batch verdicts.jsonl, summary.json and
/// page.html. A record is written when its run folder is complete, so a batch that was killed goes
/// on where it stopped.
class BatchFolder {
 public:
  /// Begins a batch, or goes on with one of the same plan if `resume`; the parts of a batch begin
  /// or go on with the same folder. `plan`: what determines the records, except the list of
  /// recordings. Throws UsageError, before any change, if the folder has a batch without `resume`,
  /// a batch with another plan, or if another process of this machine runs the same part.
  BatchFolder(std::filesystem::path folder, const nlohmann::ordered_json& plan, const Shard& shard,
              bool resume);

  /// Where the run of a recording is written.
  std::filesystem::path run_of(const BatchItem& item) const;
  /// Where the map of a recording of the place is.
  std::filesystem::path map() const { return folder_ / "place.map"; }

  /// The record of a recording; none yet. Throws UsageError if it is of another recording of the
  /// same name, InputError if it is no record.
  std::optional<nlohmann::ordered_json> record(const BatchItem& item) const;
  /// Writes a record. `timing`: what differs from run to run.
  void add(const BatchItem& item, const nlohmann::ordered_json& record,
           const nlohmann::ordered_json& timing);

  /// Writes the files of a complete batch: the bytes depend on the plan and the records alone.
  /// `difference`: to an earlier batch, for the page and difference.json; null: none. Returns the
  /// content of summary.json.
  nlohmann::ordered_json finish(std::span<const BatchItem> items,
                                const nlohmann::ordered_json& difference);

 private:
  std::filesystem::path record_of(const BatchItem& item) const;

  std::filesystem::path folder_;
  nlohmann::ordered_json plan_;
  std::optional<OutputLock> lock_;
};

/// The lines of verdicts.jsonl of a complete batch. Throws InputError with file and line.
std::vector<nlohmann::ordered_json> read_verdicts(const std::filesystem::path& folder);

}  // namespace chasles
