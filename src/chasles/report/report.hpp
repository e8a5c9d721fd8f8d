#pragma once

#include <string>
#include <vector>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// A run for the page.
struct ReportRun {
  Run run;
  /// The text of summary.json. The page shows every entry: `settings` (an object), `remarks` (a
  /// list of sentences), `version`, and each number. `chart` determines the coordinates of the
  /// NEES. Empty: nothing to show.
  std::string summary;
  /// The name of the run on the page if several runs are of one recording, such as its folder's
  /// name. Empty: its number.
  std::string label = {};
};

/// One self-contained HTML page that loads nothing: map, errors, NIS and NEES with their bounds,
/// timing, figures, settings. The function computes errors and NEES against the run's truth.
/// Several runs share the tables and the map. Runs of one recording also share a view relative to
/// the truth, over the plan if there is one. The same runs give the same bytes. Names and remarks
/// are shown as text, whatever they contain. Throws UsageError without a run, InputError if a
/// summary is not a JSON object.
std::string run_page(const std::vector<ReportRun>& runs);

/// A self-contained page of a saved map, in the same form: its landmarks by session, and what is
/// known of their uncertainty. `map` has a name, prior_map, and the summary that `chasles map
/// --json` prints. Throws UsageError without a prior_map.
std::string map_page(const ReportRun& map);

/// The page without a run. It requests the data over WebSocket from the server that delivered it,
/// and may connect to nothing else (docs/live.md).
std::string live_page();

}  // namespace chasles
