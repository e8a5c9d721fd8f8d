#pragma once

#include <filesystem>
#include <string>

#include "export_formats.hpp"

namespace chasles::app {

/// Which states an export has, if not those of the run.
struct ExportTimes {
  std::filesystem::path file;  ///< of --times, whose first column has them; empty: none
  std::string rate;            ///< of --rate: "imu" or a number [Hz]; empty: none

  bool is_asked() const { return !file.empty() || !rate.empty(); }
};

/// Replaces the states and the smoothed path of the run by those at these times: interpolated
/// (states_at()), or predicted by the IMU of the recording (predicted_path()). Returns a sentence
/// for the user. Throws UsageError for a rate that is none, both options, and rate=imu without
/// --recording or with --smoothed; InputError for a file without times, or where no state is known.
std::string states_at_times(const ExportTimes& times, const ExportChoice& choice, ReportRun& run);

}  // namespace chasles::app
