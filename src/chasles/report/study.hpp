#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <chasles/eval/chi2.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// One filter of a study over time: of one run frame by frame, of several runs the means over each
/// second. All columns have the length of `seconds`; NaN where there is no value.
struct StudyCurves {
  std::string filter;
  std::vector<double> seconds;
  std::vector<double> position_error, attitude_error;  ///< [m, deg]
  std::vector<double> nees_position, nees_attitude, nees_pose, nees_state;
  Trajectory estimate;                       ///< nav_T_imu, one pose per row; of a single run only
  std::vector<TrueLandmark> landmarks = {};  ///< estimated, in nav; of a single run only
};

/// One filter over one run: averages over its frames; NaN without a value.
struct StudyTrial {
  std::size_t filter = 0;  ///< index into Study::filters
  std::uint64_t run = 0;
  bool diverged = false;
  double position_error = 0, attitude_error = 0;  ///< [m, deg]
  double nees_position = 0, nees_attitude = 0, nees_pose = 0;
};

/// An output folder of `chasles compare` or `chasles montecarlo` in memory.
struct Study {
  std::string folder;   ///< for messages and labels
  std::string summary;  ///< the text of summary.json, whose `filters` has as many entries as
                        ///< `filters` below
  bool single_run = false;
  std::vector<StudyCurves> filters = {};
  std::vector<StudyTrial> trials = {};       ///< of several runs only
  Trajectory truth = {};                     ///< of one run alone
  std::vector<TrueLandmark> landmarks = {};  ///< of a single run only; empty where unknown
};

/// End of the name of the file with a filter's estimated landmarks, beside NAME.csv and NAME.tum.
inline constexpr const char* kLandmarksFile = "_landmarks";

/// Whether the folder contains a study rather than a run, determined from its files.
bool is_study(const std::filesystem::path& folder);

/// Reads a study folder (docs/command-line.md). Throws InputError with file, line and the expected
/// content for a file that is missing, malformed, truncated or of another study, and for an
/// incomplete study.
Study read_study(const std::filesystem::path& folder);

/// One self-contained HTML page that loads nothing: Kleinert & Stilla's table I and figure 2 for
/// the hallway, their table II and figure 3 for the turntable (view of a single run, errors and
/// NEES over time), the same without a number for other scenes; distributions over the runs,
/// outliers and settings. The same studies give the same bytes. Names are shown as text, whatever
/// they contain. Throws UsageError without a study.
std::string study_page(const std::vector<Study>& studies);

}  // namespace chasles
