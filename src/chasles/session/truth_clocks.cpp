#include <cmath>
#include <string>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/truth_imu_fit.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/turning.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/session/truth_clocks.hpp>

namespace chasles {
namespace {

constexpr Time kRateWindow = std::chrono::milliseconds(100);
constexpr double kLeastAngle = 0.5 * kRadians;  // that is worth a note
constexpr const char* kAdvice =
    "`chasles evaluate --truth-errors auto` estimates such constants with an estimate, and takes "
    "them out of its figures";

void add_fact(const char* name, double value, double sigma, const char* unit, CheckReport& report) {
  report.facts.push_back({"truth", name, value, unit});
  report.facts.push_back({"truth", fmt::format("sigma of {}", name), sigma, unit});
}

void note(const std::string& what, double value, double least, const char* unit,
          CheckReport& report) {
  report.findings.push_back({.severity = Severity::kNote,
                             .about = "truth",
                             .what = what,
                             .value = value,
                             .threshold = least,
                             .unit = unit,
                             .advice = kAdvice});
}

bool is_clear(double value, double sigma, double least) {
  return std::abs(value) > std::max(least, truth_limits::kManySigmas * sigma);
}

// The lateness of the attitudes [s].
double report_attitudes(const Recording& recording, const TruthReference& gyroscope, double start,
                        CheckReport& report) {
  const auto fit = fit_turning(rate_windows(gyroscope.poses, kRateWindow), recording.truth, start,
                               {.gap = recording.pairing.longest_gap, .biased = true});
  if (!fit || !(fit->offset_sigma < truth_limits::kMostOffsetSigma)) return -start;
  add_fact("attitudes late", -1e3 * fit->offset, 1e3 * fit->offset_sigma, "ms", report);
  const double turn = so3::log(fit->reference_R_truth).norm();
  add_fact("turn of the axes", kDegrees * turn, kDegrees * fit->rotation_sigma, "deg", report);
  if (is_clear(turn, fit->rotation_sigma, kLeastAngle)) {
    note(fmt::format("its axes differ from those of the gyroscope by {:.2f} +- {:.2f} deg",
                     kDegrees * turn, kDegrees * fit->rotation_sigma),
         kDegrees * turn, kDegrees * kLeastAngle, "deg", report);
  }
  return -fit->offset;
}

// Positions of the body's own IMU are off by up to 2 cm on short cuts of EuRoC.
void report_point(const TruthImuFit& fit, CheckReport& report) {
  constexpr double kLeastPoint = 0.05;  // [m]
  const double away = fit.point.norm(), sigma = fit.point_sigma.maxCoeff();
  add_fact("lever arm of its positions", 100 * away, 100 * sigma, "cm", report);
  if (!(away > std::max(kLeastPoint, truth_limits::kPointSigmas * sigma))) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = "truth",
       .what = fmt::format("its positions are those of a point {:.3f} +- {:.3f} m from the IMU, at "
                           "({:.3f}, {:.3f}, {:.3f}) in its axes, by the accelerometer",
                           away, sigma, fit.point.x(), fit.point.y(), fit.point.z()),
       .value = away,
       .threshold = kLeastPoint,
       .unit = "m",
       .advice = fmt::format("--truth-frame FILE moves it to the IMU; FILE has imu_T_truth, as "
                             "estimated: 1 0 0 {:.4f}; 0 1 0 {:.4f}; 0 0 1 {:.4f}; 0 0 0 1",
                             fit.point.x(), fit.point.y(), fit.point.z())});
}

void report_positions(const TruthImuFit& fit, double attitudes_late, CheckReport& report) {
  add_fact("positions late", 1e3 * fit.positions_late, 1e3 * fit.positions_late_sigma, "ms",
           report);
  add_fact("tilt", kDegrees * fit.tilt, kDegrees * fit.tilt_sigma, "deg", report);
  add_fact("heading against its positions", kDegrees * fit.heading, kDegrees * fit.heading_sigma,
           "deg", report);
  report_point(fit, report);
  const double apart = fit.positions_late - attitudes_late;
  if (is_clear(apart, fit.positions_late_sigma, truth_limits::kLeastOffset)) {
    note(
        fmt::format("its positions are {:.1f} +- {:.1f} ms {} than its attitudes, by the IMU alone",
                    1e3 * std::abs(apart), 1e3 * fit.positions_late_sigma,
                    apart > 0 ? "later" : "earlier"),
        1e3 * apart, 1e3 * truth_limits::kLeastOffset, "ms", report);
  }
  if (is_clear(fit.heading, fit.heading_sigma, kLeastAngle)) {
    note(fmt::format("its attitudes and its positions differ in heading by {:.2f} +- {:.2f} deg, "
                     "by the IMU alone",
                     kDegrees * fit.heading, kDegrees * fit.heading_sigma),
         kDegrees * fit.heading, kDegrees * kLeastAngle, "deg", report);
  }
}

}  // namespace

void report_truth_clocks(const Recording& recording, const TruthReference& gyroscope, double start,
                         CheckReport& report) {
  const double attitudes_late = report_attitudes(recording, gyroscope, start, report);
  const auto fit = fit_truth_to_imu(recording.truth, recording.imu, attitudes_late,
                                    recording.pairing.longest_gap);
  if (fit) {
    report_positions(*fit, attitudes_late, report);
    return;
  }
  report.not_checked.push_back(
      "time of the truth's positions against the IMU: that needs 20 windows of 1 s in which the "
      "body accelerates");
}

}  // namespace chasles
