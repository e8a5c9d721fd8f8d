#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/base/error.hpp>
#include <chasles/check/check_report.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/coverage.hpp>

// Whether a run of a recording may be used, and why not (docs/many.md).
namespace chasles {

/// From the best to the worst.
enum class Verdict {
  kUse,    ///< nothing speaks against the poses
  kCheck,  ///< a person should look
  kNo,     ///< there are no poses, or hardly any
};

/// "use", "check" or "no".
const char* name_of(Verdict verdict);

/// A reason against the use of a run. The names are part of the interface: scripts select by them.
struct ReasonKind {
  const char* name;
  Verdict verdict;      ///< the best one that it allows
  const char* meaning;  ///< a sentence for help and documentation, without its full stop
};

/// Changes with the rules by which a run has a reason: records of other rules are not of one batch.
inline constexpr int kRulesOfVerdicts = 1;

/// All of them, in the order in which they are reported.
std::span<const ReasonKind> reason_kinds();

/// A reason with what was found.
struct Reason {
  std::string kind;
  std::string what;  ///< with the measured value
};

/// Of the kind with that name, which must be one of reason_kinds().
Verdict verdict_of(const Reason& reason);
/// The worst of all; kUse without one.
Verdict verdict_of(std::span<const Reason> reasons);

/// The limits that depend on what the poses are for.
struct VerdictLimits {
  double least_coverage = 0.8;  ///< share of the frames with an estimate
  double most_sigma = 0.1;      ///< standard deviation of a position [m] ...
  double most_drift = 1;        ///< ... or for each 100 m of path [m]: of long paths this counts
  double most_nis = 2;          ///< mean NIS of a filter, for each degree of freedom
};

/// Figures of the poses that a run gives its users.
struct PathFigures {
  /// Which poses: "in_map" of a run in a map, else "smoothed" where there are such, else "states".
  std::string path;
  std::size_t poses = 0;
  double coverage = 0;  ///< frames with such a pose over all frames of the recording
  double length_m = 0;
  double worst_sigma_m = 0;     ///< along the worst axis of the worst pose [m]
  double worst_turn_deg = 0;    ///< the same of the rotation [deg]
  double drift_m_per_100m = 0;  ///< worst_sigma_m for each 100 m of the path; 0 of less than 1 m
};

/// Of the poses that are not lost; none without any. `coverage`: of the run; `in_map`: the run was
/// to find its place. Figures of a covariance that is not finite are infinite.
std::optional<PathFigures> path_figures(const Run& run, const FrameCoverage& coverage, bool in_map);

/// The bound of a verdict is this many times the worst standard deviation of a position. Errors
/// stay below it where the covariance is that of the errors (docs/many.md).
inline constexpr double kBoundSigmas = 4;

/// The reason for a run that ended with an error.
Reason reason_of(const Error& error);

/// What speaks against a run with these poses. `summary`: content of summary.json. `check`: of the
/// recording. `known`: what is known already. Several findings of a kind are one reason.
std::vector<Reason> reasons_against(const nlohmann::ordered_json& summary,
                                    const std::optional<PathFigures>& path, bool in_map,
                                    const CheckReport& check, const VerdictLimits& limits,
                                    std::vector<Reason> known = {});

}  // namespace chasles
