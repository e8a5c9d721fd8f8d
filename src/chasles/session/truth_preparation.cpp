#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/check/check_truth.hpp>
#include <chasles/eval/position_fit.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/gravity.hpp>
#include <chasles/session/truth_clocks.hpp>
#include <chasles/session/truth_mending.hpp>
#include <chasles/session/truth_preparation.hpp>

namespace chasles {
namespace {

TruthExaminationOptions examination_options(const TruthToPrepare& how) {
  return {.gap = how.pairing.longest_gap,
          .interpolated = how.pairing.pairing == Pairing::kInterpolate,
          .positions_only = !how.attitudes,
          .levelled = how.turn_to_level};
}

void apply_offset(const TruthReference& reference, const TruthToPrepare& how, Trajectory& truth,
                  PreparedTruth& prepared_truth) {
  const TruthExamination examination = examine_truth(reference, truth, examination_options(how));
  if (!examination.clock) {
    throw InputError(fmt::format(
        "--truth-time-offset auto: the motion of the truth and of {} does not determine the offset "
        "of their clocks; state it in seconds (--truth-time-offset S)",
        reference.name));
  }
  const TruthClock& clock = *examination.clock;
  for (StampedPose& row : truth) row.time += from_seconds(clock.offset);
  prepared_truth.remarks.push_back(fmt::format(
      "{:.4f} +- {:.1g} s were added to the truth's times, by its {} against those of {} "
      "(--truth-time-offset auto)",
      clock.offset, clock.sigma, clock.by_rotations ? "rotations" : "positions", reference.name));
}

// The positions of a point on the body become those of the IMU, by the attitudes of the reference
// in the truth's world. Two passes: the worlds are aligned by what is moved.
void move_point(const TruthReference& reference, const TruthToPrepare& how, Trajectory& truth,
                PreparedTruth& prepared_truth) {
  if (!reference.positions || how.point_imu.isZero(0)) return;
  const Trajectory given = truth;
  for (int pass = 0; pass < 2; ++pass) {
    const auto fit = fit_positions(reference.poses, truth, {.gap = how.pairing.longest_gap});
    if (!fit) return;
    Trajectory moved;
    for (const StampedPose& row : given) {
      const auto body = pose_at(reference.poses, row.time, how.pairing.longest_gap);
      if (!body) continue;
      const Eigen::Vector3d lever = fit->truth_T_estimate.R * (body->R * how.point_imu);
      moved.push_back({row.time, {Eigen::Matrix3d::Identity(), row.pose.p - lever}});
    }
    if (moved.empty()) return;
    truth = std::move(moved);
  }
  prepared_truth.remarks.push_back(fmt::format(
      "the truth's positions are those of a point at ({:.3f}, {:.3f}, {:.3f}) m in IMU axes: moved "
      "to the IMU by the attitudes of {}",
      how.point_imu.x(), how.point_imu.y(), how.point_imu.z(), reference.name));
}

// Of positions alone, by the best rigid motion.
TruthTilt tilt_of_positions(const TruthReference& reference, const TruthToPrepare& how,
                            const Trajectory& truth) {
  const auto fit = fit_positions(reference.poses, truth, {.gap = how.pairing.longest_gap});
  if (!fit) return {};
  const Eigen::Vector3d up = fit->truth_T_estimate.R.col(2);
  return {.level_R_truth = so3::between(up, Eigen::Vector3d::UnitZ()),
          .degrees = kDegrees * std::atan2(up.head<2>().norm(), up.z())};
}

void level_out(const TruthReference& reference, const TruthToPrepare& how, Trajectory& truth,
               PreparedTruth& prepared_truth) {
  if (!how.turn_to_level) return;
  const bool attitudes = how.attitudes && !is_without_attitudes(reference.poses, truth);
  if (attitudes) {
    prepared_truth.tilt = turn_to_level(truth, reference.poses, how.pairing);
  } else {
    prepared_truth.tilt = tilt_of_positions(reference, how, truth);
    for (StampedPose& row : truth) row.pose.p = prepared_truth.tilt->level_R_truth * row.pose.p;
  }
  prepared_truth.remarks.push_back(tilt_remark(prepared_truth.tilt->degrees));
}

// Of positions scaled by s, what the accelerometer leaves is a parabola in s, as the fit is linear:
// three values give its lowest point. None if the motion does not show it.
std::optional<TruthFinding> unit_by_accelerometer(const Recording& recording) {
  constexpr double kExplained = 0.1;  // of the squares without any motion, that may be left
  const auto left = [&](double scale) {
    Trajectory scaled = recording.truth;
    for (StampedPose& row : scaled) row.pose.p *= scale;
    const auto fit = fit_gravity(scaled, recording.imu);
    return fit ? fit->left * fit->left : kNaN;
  };
  const double unshifted = left(0), here = left(1), mirrored = left(-1);
  const double slope = (here - mirrored) / 2, bend = (here + mirrored) / 2 - unshifted;
  const double scale = -slope / (2 * bend);
  if (!(scale > 0) || !(left(scale) < kExplained * unshifted)) return std::nullopt;
  return unit_finding(1 / scale, "those of the accelerometer");
}

}  // namespace

PreparedTruth prepare_truth(const TruthReference& reference, const TruthToPrepare& how,
                            Trajectory& truth) {
  PreparedTruth prepared_truth;
  if (how.estimate_offset) apply_offset(reference, how, truth, prepared_truth);
  move_point(reference, how, truth, prepared_truth);
  level_out(reference, how, truth, prepared_truth);
  TruthExamination examination = examine_truth(reference, truth, examination_options(how));
  prepared_truth.findings = std::move(examination.findings);
  prepared_truth.attitudes = examination.attitudes;
  return prepared_truth;
}

TruthReference gyroscope_reference(const Recording& recording) {
  TruthReference reference{.name = "the gyroscope",
                           .poses = {},
                           .positions = false,
                           .biased = true,
                           .level = {},
                           .frames = known_frames(recording)};
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (std::size_t i = 0; i < recording.imu.size(); ++i) {
    const ImuSample& sample = recording.imu[i];
    if (i > 0) {
      const ImuSample& before = recording.imu[i - 1];
      const Eigen::Vector3d rate = (before.angular_rate_imu + sample.angular_rate_imu) / 2;
      R = R * so3::exp(to_seconds(sample.time - before.time) * rate);
      if (i % 1000 == 0) R = so3::normalized(R);
    }
    reference.poses.push_back({sample.time, {R, Eigen::Vector3d::Zero()}});
  }
  return reference;
}

void report_truth_examination(const Recording& recording, CheckReport& report) {
  if (recording.truth.empty() || recording.imu.empty()) return;
  const TruthReference gyroscope = gyroscope_reference(recording);
  TruthExamination examination = examine_truth(
      gyroscope, recording.truth,
      {.gap = recording.pairing.longest_gap, .positions_only = !recording.truth_attitudes});
  if (examination.clock) {
    report.facts.push_back({"truth", "offset of its clock", 1e3 * examination.clock->offset, "ms"});
  }
  if (examination.attitudes && examination.findings.empty()) {
    if (auto unit = unit_by_accelerometer(recording)) examination.findings.push_back(*unit);
  }
  const bool clock_alone = std::ranges::all_of(
      examination.findings, [](const TruthFinding& f) { return f.fault == TruthFault::kClock; });
  if (examination.attitudes && clock_alone) {
    report_truth_clocks(recording, gyroscope, examination.clock ? examination.clock->offset : 0,
                        report);
  }
  // Gravity leans because of what is found.
  if (!examination.findings.empty()) {
    std::erase_if(report.findings, [](const Finding& finding) {
      return finding.about == "truth" && finding.what.starts_with(kLeanBegins);
    });
  }
  for (const TruthFinding& finding : examination.findings) {
    report.findings.push_back({.severity = Severity::kWarning,
                               .about = "truth",
                               .what = finding.what,
                               .value = finding.value,
                               .threshold = finding.threshold,
                               .unit = finding.unit,
                               .advice = finding.advice});
  }
}

nlohmann::ordered_json truth_findings_json(const std::vector<TruthFinding>& findings) {
  auto json = nlohmann::ordered_json::array();
  for (const TruthFinding& finding : findings) {
    json.push_back({{"finding", name(finding.fault)},
                    {"what", finding.what},
                    {"value", finding.value},
                    {"sigma", finding.sigma},
                    {"threshold", finding.threshold},
                    {"unit", finding.unit},
                    {"advice", finding.advice}});
  }
  return json;
}

}  // namespace chasles
