#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <chasles/live/comparison.hpp>
#include <chasles/live/live_run.hpp>

// The updates for viewers as text (docs/live.md).
namespace chasles {

/// A range of a growing run.
struct LiveRows {
  std::string_view id;
  std::size_t from = 0, to = 0;  ///< states
  bool truth = false;            ///< with the true trajectory, if it can be aligned
  std::uint64_t landmarks = 0;   ///< version of the landmarks to send; 0: none
  bool prior_map = false;        ///< with the prior map
};

/// Parts of summary.json (objects).
struct LiveSummary {
  const std::string& before;  ///< known before the run
  const std::string& known;   ///< LiveMap::known
};

/// The states of the range in the page's columns (run_data() of report/page_data.hpp), preceded by
/// the run's first state, which is the reference of the columns.
std::string rows_text(const Run& run, const LiveSummary& summary,
                      const GrowingComparison& comparison, const LiveRows& rows,
                      const LiveProgress& progress);

/// The text before the first estimate.
std::string progress_text(std::string_view id, const LiveProgress& progress);

/// The whole page of finished runs.
std::string page_text(std::string_view id, const std::vector<ReportRun>& runs,
                      const LiveProgress& progress);

}  // namespace chasles
