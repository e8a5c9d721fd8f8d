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

namespace chasles::app {

/// plan.json: all that the records of a study depend on, but which runs there are. Two folders with
/// the same plan are parts of one study.
nlohmann::ordered_json plan_json(const InertialScene& scene,
                                 std::span<const FilterVariant> filters);

nlohmann::ordered_json plan_json(const LoopsSettings& scene,
                                 std::span<const FilterVariant> filters);

/// The filters of a plan, by their names and charts, which is what a summary needs.
std::vector<FilterVariant> filters_of(const nlohmann::ordered_json& plan);

/// A record as a line of trials.jsonl, with its end. Numbers are written so that they are read back
/// the same; NaN is null.
std::string to_line(const TrialRecord& record);

/// Throws InputError that begins with `where` for a line that is none.
TrialRecord from_line(const std::string& line, const std::string& where);

/// The folder of a study: plan.json, trials.jsonl with a line for each run and filter, and once it
/// is complete summary.json and curves.csv.
class TrialLog {
 public:
  /// Begins a study of these runs (in order), or goes on with one where `resume`: then a run whose
  /// lines are not all there is dropped, to be done again. Throws UsageError, before anything is
  /// touched, where the folder holds a study and it is not resumed, or where that has another plan
  /// or other runs, which would count in silence.
  TrialLog(const std::filesystem::path& folder, const nlohmann::ordered_json& plan,
           std::span<const std::uint64_t> runs, bool resume);

  /// The complete studies of some folders as one, in a new folder. Throws UsageError for plans that
  /// differ and for a run that is in two of them, InputError for a study that is not complete.
  static TrialLog merged(std::span<const std::filesystem::path> folders,
                         std::filesystem::path folder);

  bool has(std::uint64_t run) const { return lines_.contains(run); }
  std::size_t runs() const { return lines_.size(); }

  /// Keeps the lines of a run, one for each filter, and puts them on the disk at once.
  void add(std::uint64_t run, const std::string& lines);

  /// Writes trials.jsonl in the order of the runs, summary.json and curves.csv, and returns the
  /// summaries. The bytes depend on the plan and the records alone.
  std::vector<FilterSummary> finish();

  const nlohmann::ordered_json& summary() const { return summary_; }  ///< once finished

 private:
  using Lines = std::map<std::uint64_t, std::string>;  // of a run, all filters

  TrialLog(std::filesystem::path folder, nlohmann::ordered_json plan, Lines lines);
  std::filesystem::path trials() const { return folder_ / "trials.jsonl"; }
  void write_trials() const;

  std::filesystem::path folder_;
  nlohmann::ordered_json plan_;
  Lines lines_;
  nlohmann::ordered_json summary_;
};

}  // namespace chasles::app
