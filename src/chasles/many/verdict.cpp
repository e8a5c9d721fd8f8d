#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/many/verdict.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kReasons = {
    ReasonKind{"unreadable", Verdict::kNo, "the recording cannot be read"},
    ReasonKind{"settings", Verdict::kNo, "the settings do not suit the recording"},
    ReasonKind{"not_estimated", Verdict::kNo, "the estimator cannot use what the recording has"},
    ReasonKind{"not_initialised", Verdict::kNo, "the estimator found no initial state"},
    ReasonKind{"lost", Verdict::kNo, "the estimate was lost, and the run ended without it"},
    ReasonKind{"no_place", Verdict::kNo, "the run did not find its place in the map"},
    ReasonKind{"few_estimates", Verdict::kNo, "less than half of the frames have an estimate"},
    ReasonKind{"time", Verdict::kNo, "the run took longer than its bound"},
    ReasonKind{"memory", Verdict::kNo, "the run needed more memory than its bound"},
    ReasonKind{"died", Verdict::kNo, "the process of the run died twice, or met an internal error"},
    // A run mends some errors that it measures, and its sigmas know of others.
    ReasonKind{"check_error", Verdict::kCheck, "`chasles check` finds an error in the recording"},
    ReasonKind{"filter_only", Verdict::kCheck,
               "batch estimation cannot use the recording: the poses are the filter's"},
    ReasonKind{"coverage", Verdict::kCheck, "the coverage is below its limit"},
    ReasonKind{"degraded", Verdict::kCheck,
               "the estimate was degraded, or began anew after a loss"},
    ReasonKind{"uncertain", Verdict::kCheck,
               "the standard deviation of a position is above its limit"},
    ReasonKind{"innovations", Verdict::kCheck, "the mean NIS is above its limit"},
    ReasonKind{"calibration", Verdict::kCheck,
               "a parameter is more than 4 sigma from the calibration"},
    ReasonKind{"imu", Verdict::kCheck, "IMU samples are missing, saturated or no measurements"},
    ReasonKind{"images", Verdict::kCheck, "images cannot be read"},
    ReasonKind{"check_warning", Verdict::kCheck, "`chasles check` warns of the recording"},
};

const ReasonKind& kind_of(const Reason& reason) {
  return *std::ranges::find_if(kReasons,
                               [&](const ReasonKind& kind) { return reason.kind == kind.name; });
}

double largest_sigma(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}

// Of the poses of a range, all of which count.
template <typename Poses>
std::optional<PathFigures> figures_of(const char* path, const Poses& poses) {
  PathFigures figures{.path = path};
  const Eigen::Vector3d* before = nullptr;
  for (const auto& pose : poses) {
    const Matrix6d& covariance = pose.pose_covariance;
    figures.worst_turn_deg =
        std::max(figures.worst_turn_deg,
                 largest_sigma(covariance.topLeftCorner<3, 3>()) * 180 / std::numbers::pi);
    figures.worst_sigma_m =
        std::max(figures.worst_sigma_m, largest_sigma(covariance.bottomRightCorner<3, 3>()));
    if (before) figures.length_m += (pose.world_T_imu.p - *before).norm();
    before = &pose.world_T_imu.p;
    ++figures.poses;
  }
  if (figures.poses == 0) return std::nullopt;
  if (figures.length_m >= 1) {
    figures.drift_m_per_100m = 100 * figures.worst_sigma_m / figures.length_m;
  }
  return figures;
}

// Collects what speaks against a run; findings of a kind become one reason.
class Reasons {
 public:
  explicit Reasons(std::vector<Reason> known) : list_(std::move(known)) {}

  void add(const std::string& kind, const std::string& what) {
    const auto known = std::ranges::find(list_, kind, &Reason::kind);
    if (known == list_.end()) {
      list_.push_back({kind, what});
    } else {
      known->what += "; " + what;
    }
  }

  // In the order of reason_kinds().
  std::vector<Reason> take() {
    std::ranges::stable_sort(list_, {}, [](const Reason& reason) { return &kind_of(reason); });
    return std::move(list_);
  }

 private:
  std::vector<Reason> list_;
};

std::optional<double> number_in(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

void assess_coverage(double coverage, const VerdictLimits& limits, Reasons& reasons) {
  const std::string what = fmt::format("{:.0f} % of the frames have an estimate", 100 * coverage);
  if (coverage < kLeastCoverage) {
    reasons.add("few_estimates", what);
  } else if (coverage < limits.least_coverage) {
    reasons.add("coverage",
                fmt::format("{}, expected {:.0f} %", what, 100 * limits.least_coverage));
  }
}

void assess_health(const Json& summary, Reasons& reasons) {
  const std::string health = summary.value("health", "ok");
  if (health == "lost") {
    reasons.add("lost", fmt::format("the estimate was lost after {:.0f} frames",
                                    number_in(summary, "frames").value_or(0)));
    return;
  }
  if (const double resets = number_in(summary, "resets").value_or(0); resets > 0) {
    reasons.add("degraded", fmt::format("began anew after {:.0f} losses", resets));
  }
  const double bad = number_in(summary, "frames_not_ok").value_or(0);
  const double frames = std::max(1.0, number_in(summary, "frames").value_or(0));
  if (health == "degraded" && bad > 0) {
    reasons.add("degraded", fmt::format("{:.0f} % of the frames are degraded", 100 * bad / frames));
  }
}

void assess_path(const PathFigures& path, const VerdictLimits& limits, Reasons& reasons) {
  const double most = std::max(limits.most_sigma, limits.most_drift * path.length_m / 100);
  if (!std::isfinite(path.worst_sigma_m + path.worst_turn_deg)) {
    reasons.add("uncertain", "a covariance is not finite");
    return;
  }
  if (path.worst_sigma_m > most) {
    reasons.add(
        "uncertain",
        fmt::format("a position's standard deviation is {:.3f} m, expected at most {:.3f} m",
                    path.worst_sigma_m, most));
  }
}

void assess_innovations(const Json& summary, const VerdictLimits& limits, Reasons& reasons) {
  const std::optional<double> nis = number_in(summary, "nis_per_dof");
  if (nis && *nis > limits.most_nis) {
    reasons.add("innovations",
                fmt::format("the mean NIS for each degree of freedom is {:.2f}, expected at most "
                            "{:.2f}",
                            *nis, limits.most_nis));
  }
}

void assess_calibration(const Json& summary, Reasons& reasons) {
  constexpr double kMostSigmas = 4;
  const auto calibration = summary.find("calibration");
  if (calibration == summary.end() || !calibration->contains("parameters")) return;
  for (const Json& parameter : calibration->at("parameters")) {
    const auto stated = number_in(parameter, "stated"),
               sigma = number_in(parameter, "stated_sigma"),
               estimate = number_in(parameter, "estimate");
    if (!stated || !sigma || !estimate || *sigma <= 0) continue;
    const double moved = std::abs(*estimate - *stated) / *sigma;
    if (moved <= kMostSigmas) continue;
    reasons.add("calibration", fmt::format("{} is {:.4g} {}, {:.1f} sigma from {:.4g}",
                                           parameter.at("name").get<std::string>(), *estimate,
                                           parameter.value("unit", ""), moved, *stated));
  }
}

// A few samples that are bridged are no reason.
void assess_imu(const Json& summary, Reasons& reasons) {
  const auto imu = summary.find("imu");
  if (imu == summary.end()) return;
  const double used = std::max(1.0, number_in(*imu, "used").value_or(0));
  for (const auto& [name, meaning] : {std::pair{"gaps", "gaps"},
                                      {"saturated", "saturated samples"},
                                      {"frozen", "frozen samples"},
                                      {"interpolated", "interpolated samples"},
                                      {"spikes", "spikes"},
                                      {"not_finite", "samples that are not finite"},
                                      {"zero", "samples of zeros"},
                                      {"extrapolated", "frames beyond the last sample"}}) {
    const double count = number_in(*imu, name).value_or(0);
    const double most = std::string(name) == "gaps" ? 0 : 0.002 * used;
    if (count > most) reasons.add("imu", fmt::format("{:.0f} {}", count, meaning));
  }
}

void assess_images(const Json& summary, Reasons& reasons) {
  const auto frontend = summary.find("frontend");
  if (frontend == summary.end()) return;
  const double unreadable = number_in(*frontend, "unreadable").value_or(0);
  const double frames = std::max(1.0, number_in(*frontend, "frames").value_or(0));
  if (unreadable > 0.01 * frames) {
    reasons.add("images",
                fmt::format("{:.0f} of {:.0f} images cannot be read", unreadable, frames));
  }
}

void assess_check(const CheckReport& check, Reasons& reasons) {
  for (const Finding& finding : check.findings) {
    if (finding.severity == Severity::kNote) continue;
    reasons.add(finding.severity == Severity::kError ? "check_error" : "check_warning",
                finding.about + ": " + finding.what);
  }
}

}  // namespace

const char* name_of(Verdict verdict) {
  return verdict == Verdict::kUse ? "use" : verdict == Verdict::kCheck ? "check" : "no";
}

std::span<const ReasonKind> reason_kinds() { return kReasons; }

Verdict verdict_of(const Reason& reason) { return kind_of(reason).verdict; }

Verdict verdict_of(std::span<const Reason> reasons) {
  Verdict worst = Verdict::kUse;
  for (const Reason& reason : reasons) worst = std::max(worst, verdict_of(reason));
  return worst;
}

std::optional<PathFigures> path_figures(const Run& run, const FrameCoverage& coverage,
                                        bool in_map) {
  if (in_map) {
    std::optional<PathFigures> figures = figures_of("in_map", run.in_map);
    if (figures) {
      figures->coverage =
          FrameCoverage{.estimated = figures->poses, .frames = coverage.frames}.share();
    }
    return figures;
  }
  std::vector<RunState> kept;
  std::ranges::copy_if(run.states, std::back_inserter(kept),
                       [](const RunState& state) { return state.health != "lost"; });
  std::optional<PathFigures> figures =
      run.smoothed.empty() ? figures_of("states", kept) : figures_of("smoothed", run.smoothed);
  if (figures) figures->coverage = coverage.share();
  return figures;
}

Reason reason_of(const Error& error) {
  switch (error.code()) {
    case ExitCode::kUsage:
      return {"settings", error.what()};
    case ExitCode::kNotInitialised:
      return {"not_initialised", error.what()};
    case ExitCode::kDiverged:
      return {"lost", error.what()};
    default:
      return {"unreadable", error.what()};
  }
}

std::vector<Reason> reasons_against(const Json& summary, const std::optional<PathFigures>& path,
                                    bool in_map, const CheckReport& check,
                                    const VerdictLimits& limits, std::vector<Reason> known) {
  Reasons reasons(std::move(known));
  if (path || !in_map) assess_coverage(path ? path->coverage : 0, limits, reasons);
  assess_health(summary, reasons);
  if (path) {
    assess_path(*path, limits, reasons);
  } else if (in_map) {
    reasons.add("no_place", "no part of the map was recognised");
  }
  assess_innovations(summary, limits, reasons);
  assess_calibration(summary, reasons);
  assess_imu(summary, reasons);
  assess_images(summary, reasons);
  assess_check(check, reasons);
  return reasons.take();
}

}  // namespace chasles
