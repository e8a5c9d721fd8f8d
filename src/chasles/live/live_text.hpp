#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <chasles/live/comparison.hpp>
#include <chasles/live/live_run.hpp>

// What viewers are told, as text (docs/live.md).
namespace chasles {

/// A piece of a run that grows.
struct LiveRows {
  std::string_view id;
  std::size_t from = 0, to = 0;  ///< states
  bool truth = false;            ///< with the true way, where it can be placed
  std::uint64_t landmarks = 0;   ///< version of the landmarks to send; 0: none
};

/// Its states in the page's own columns (run_data() of report/page_data.hpp), behind the first
/// state of all, which the columns are relative to.
std::string rows_text(const Run& run, const std::string& summary,
                      const GrowingComparison& comparison, const LiveRows& rows,
                      const LiveProgress& progress);

/// Before there is an estimate.
std::string progress_text(std::string_view id, const LiveProgress& progress);

/// The whole page of runs that are finished.
std::string page_text(std::string_view id, const std::vector<ReportRun>& runs,
                      const LiveProgress& progress);

}  // namespace chasles
