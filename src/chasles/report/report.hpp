#pragma once

#include <string>
#include <vector>

#include <chasles/data/run.hpp>

namespace chasles {

/// A run as the page shows it.
struct ReportRun {
  Run run;
  /// The text of summary.json. The page shows every entry: `settings` (an object), `remarks` (a
  /// list of sentences), `version`, and each number, known by name or not. `chart` decides in
  /// which coordinates the NEES is measured. Empty: nothing to show.
  std::string summary;
  /// What the page calls it where several runs are of one recording, as the folder's name. Empty:
  /// its number.
  std::string label = {};
};

/// One HTML page that holds everything and loads nothing: map, errors, NIS and NEES with their
/// bounds, timing, figures, settings. Errors and NEES against the run's truth are computed here;
/// several runs share the tables and the map, and those of one recording a view of all of them on
/// the truth, over the plan where there is one. The same runs give the same bytes. Names and
/// remarks are shown as text, whatever they contain. Throws UsageError without a run, InputError
/// when a summary is not a json object.
std::string run_page(const std::vector<ReportRun>& runs);

/// The same page without a run: it asks the server that it comes from, over WebSocket, and may
/// connect to nothing else (docs/live.md).
std::string live_page();

}  // namespace chasles
