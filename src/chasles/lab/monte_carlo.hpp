#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <chasles/eval/chi2.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_settings.hpp>

namespace chasles {

/// The same runs of a scene through several filters. In each run all filters get the same
/// landmarks, noise and initial errors.
struct MonteCarloPlan {
  InertialScene scene;
  std::vector<FilterVariant> filters;
  std::vector<std::uint64_t> runs;
};

/// A trial without its details: its averages, and its errors per second.
struct TrialRecord {
  std::string filter;
  std::uint64_t run = 0;
  bool diverged = false;
  TrialAverages averages;
  /// Means over each second: position error [m], attitude error [rad], NEES of position, attitude
  /// and pose, and joint NEES of pose, velocity and biases.
  struct Second {
    double position_error = 0, attitude_error = 0;
    double nees_position = 0, nees_attitude = 0, nees_pose = 0, nees_state = 0;
  };
  std::vector<Second> seconds;
  std::vector<Second> smoothed = {};  ///< likewise of the smoothed path, where the filter has it
};
TrialRecord record_of(const Trial& trial);

/// The records of one run, one per filter.
using RecordsOfRun = std::function<std::vector<TrialRecord>(std::uint64_t run)>;
using RecordsDone = std::function<void(std::span<const TrialRecord>)>;

/// Executes the runs in `workers` processes. `done` receives the records of a run; the order of
/// runs is not fixed. If `records` depends on the run alone, the records do not depend on workers
/// or order.
void run_monte_carlo(const std::vector<std::uint64_t>& runs, int workers,
                     const RecordsOfRun& records, const RecordsDone& done);

/// The same for the runs of a plan.
void run_monte_carlo(const MonteCarloPlan& plan, int workers, const RecordsDone& done);

/// One filter over all runs. Averages are over the runs that did not diverge.
struct FilterSummary {
  std::string filter;
  std::size_t runs = 0, diverged = 0;
  TrialAverages mean = {};       ///< of the runs' averages
  TrialAverages median = {};     ///< of the runs' averages
  double nees_per_dof = 0;       ///< of the pose
  double covariance_factor = 0;  ///< factor by which the covariance is too small: nees_per_dof
  Band band = {};  ///< 95 % band of nees_per_dof at one instant, for this number of runs
  double seconds_inside =
      0;  ///< fraction of the seconds in which the mean over the runs is inside the band
  std::vector<TrialRecord::Second> seconds = {};  ///< means over the runs
};

/// The summaries in the order of `filters`; records in any order.
std::vector<FilterSummary> summarize(std::span<const FilterVariant> filters,
                                     std::span<const TrialRecord> records);

}  // namespace chasles
