#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/eval/chi2.hpp>

namespace chasles {

/// One filter of a study over time: of one run frame by frame, of several the means second by
/// second. All columns have the length of `seconds`; NaN where there is no number.
struct StudyCurves {
  std::string filter;
  std::vector<double> seconds;
  std::vector<double> position_error, attitude_error;  ///< [m, deg]
  std::vector<double> nees_position, nees_attitude, nees_pose, nees_state;
  Trajectory estimate;  ///< nav_T_imu, a pose a row; of one run alone
};

/// One filter over one run: averages over its frames, NaN where there is none.
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
  std::string summary;  ///< the text of summary.json, whose `filters` are as many as below
  bool single_run = false;
  std::vector<StudyCurves> filters = {};
  std::vector<StudyTrial> trials = {};       ///< of several runs alone
  Trajectory truth = {};                     ///< of one run alone
  std::vector<TrueLandmark> landmarks = {};  ///< of one run alone; empty where unknown
};

/// Whether the folder holds a study, and not a run: told by what is in it.
bool is_study(const std::filesystem::path& folder);

/// Reads such a folder (docs/command-line.md). Throws InputError with file, line and what was
/// expected for a file that is missing, malformed, truncated or of another study, and for a study
/// that is not complete.
Study read_study(const std::filesystem::path& folder);

/// One HTML page that holds everything and loads nothing: Kleinert & Stilla's tables I and II with
/// the chi-square bands, their figures 2 (top view, of one run) and 3 (errors and NEES over time),
/// distributions over the runs, outliers and settings. The same studies give the same bytes. Names
/// are shown as text, whatever they contain. Throws UsageError without a study.
std::string study_page(const std::vector<Study>& studies);

}  // namespace chasles
