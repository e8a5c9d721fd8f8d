#include "subcommands.hpp"

namespace chasles::app {

std::span<const Subcommand> subcommands() {
  static constexpr Subcommand list[] = {
      {"run", "Estimate the trajectory and the map of a recording", declare_run},
      {"batch", "Run many recordings: a verdict on each, and a page", declare_batch},
      {"check", "Check a recording before a run: clocks, gaps, exposure, calibration",
       declare_check},
      {"calibrate",
       "Calibrate cameras and IMU: targets, lenses, mounting, clocks, noise, conversion",
       declare_calibrate},
      {"simulate", "Write a simulated recording", declare_simulate},
      {"compare", "Run several filters on the same data: tables of errors and NEES",
       declare_compare},
      {"montecarlo", "Average errors and NEES of filters over many runs of a scene",
       declare_montecarlo},
      {"evaluate", "Compare a trajectory with the truth: ATE, RPE, NEES", declare_evaluate},
      {"report", "Write one HTML page of runs or of studies", declare_report},
      {"view", "Serve the page of runs to a browser, until Ctrl-C", declare_view},
      {"map", "Describe a saved map, or merge several", declare_map},
      {"export", "Write a run for other programs: MCAP, PLY, TUM, nerfstudio, ...", declare_export},
      {"completion", "Print a shell's program that completes this command's arguments",
       declare_completion},
  };
  return list;
}

}  // namespace chasles::app
