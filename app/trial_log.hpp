#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/lab/loops_settings.hpp>
#include <chasles/lab/monte_carlo.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles::app {

/// Content of plan.json: everything that determines the records of a study, except the list of
/// runs. Two folders with the same plan are parts of one study.
nlohmann::ordered_json plan_json(const InertialScene& scene,
                                 std::span<const FilterVariant> filters);

nlohmann::ordered_json plan_json(const LoopsSettings& scene,
                                 std::span<const FilterVariant> filters);

/// The filters of a plan; only the fields that a summary needs.
std::vector<FilterVariant> filters_of(const nlohmann::ordered_json& plan);

/// A record as a line of trials.jsonl, with the line end. Numbers keep their exact value when read
/// back; NaN becomes null.
std::string to_line(const TrialRecord& record);

/// Parses a line of trials.jsonl. Throws InputError that starts with `where` for an invalid line.
TrialRecord from_line(const std::string& line, const std::string& where);

/// The folder of a study: plan.json, and trials.jsonl with a line for each run and filter. A
/// complete study also has summary.json and curves.csv.
class TrialLog {
 public:
  /// Starts a study of these runs (ascending), or continues one if `resume`. A continued study
  /// drops incomplete runs, which are then repeated. Throws UsageError, before any change, if the
  /// folder holds a study without `resume`, a study with another plan, or runs that are not in
  /// `runs`, or if another process writes into it.
  TrialLog(const std::filesystem::path& folder, const nlohmann::ordered_json& plan,
           std::span<const std::uint64_t> runs, bool resume);

  /// Merges complete studies into one, in a new folder. Throws UsageError for different plans and
  /// for a run that is in two studies, InputError for an incomplete study.
  static TrialLog merged(std::span<const std::filesystem::path> folders,
                         std::filesystem::path folder);

  bool has(std::uint64_t run) const { return lines_.contains(run); }
  std::size_t runs() const { return lines_.size(); }

  /// Adds the lines of a run, one for each filter, and writes them to disk immediately.
  void add(std::uint64_t run, const std::string& lines);

  /// Writes trials.jsonl in the order of the runs, summary.json and curves.csv. Returns the
  /// summaries. The bytes depend only on the plan and the records.
  std::vector<FilterSummary> finish();

  const nlohmann::ordered_json& summary() const { return summary_; }  ///< after finish()

 private:
  using Lines = std::map<std::uint64_t, std::string>;  // by run; the lines of all filters

  explicit TrialLog(std::filesystem::path folder);
  TrialLog(std::filesystem::path folder, const nlohmann::ordered_json& plan, Lines lines);
  void begin(const nlohmann::ordered_json& plan, Lines lines);
  std::filesystem::path trials() const { return folder_ / "trials.jsonl"; }
  void write_trials() const;

  std::filesystem::path folder_;
  OutputLock lock_;
  nlohmann::ordered_json plan_;
  Lines lines_;
  nlohmann::ordered_json summary_;
};

}  // namespace chasles::app
