#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include <chasles/base/constants.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_reading.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kLeastSignal = 0.02;  // [rad/s]
constexpr double kMostUnexplained = 0.35;
constexpr double kMisaligned = 0.1;  // sine of the angle that still counts as the same axes
constexpr double kDetermined = 3 * kRadians;
constexpr double kAlike = 1.5;  // of residuals
constexpr std::size_t kWindowsOfUnlike = 40;
constexpr double kOtherSide = 0.95;       // of the residual at the opposite offset
constexpr double kNothingCompared = 1e9;  // unexplained
// Noise of attitudes counts less over longer intervals [s].
constexpr std::array kWindowLengths{0.1, 0.5, 1.0};

constexpr std::array kReadings{TruthReading::kAsRead, TruthReading::kWFirst, TruthReading::kInverse,
                               TruthReading::kWFirstInverse};

// A reading at one shift of the clock.
struct Candidate {
  std::size_t reading = 0;
  TurningFit fit;
};

// What the candidates are compared by.
struct Trial {
  std::vector<RateWindow> windows;
  TurningOptions options;
  bool only;  // one reading is tried
  std::array<Trajectory, kReadings.size()> truths = {};
  std::vector<Candidate> candidates = {};
  double best = std::numeric_limits<double>::infinity();  // residual [rad/s]

  // The residual of a candidate with that rotation, if it explains the rates.
  std::optional<double> residual(const Candidate& c, const Eigen::Matrix3d& R) const {
    if (c.fit.unexplained() > kMostUnexplained) return std::nullopt;
    const double r = turning_residual(windows, truths[c.reading], c.fit.offset, R, options);
    const double allowed = kMisaligned * c.fit.signal;
    return r * r <= best * best + allowed * allowed ? std::optional(r) : std::nullopt;
  }
};

// Of several shifts that explain the rates alike the one nearest to zero, if it is near.
struct Shift {
  const Candidate* candidate = nullptr;
  double residual = std::numeric_limits<double>::infinity();
  bool clear = true;  // no other one is as good
};

void offer(const Candidate& candidate, double residual, Shift& shift) {
  if (shift.candidate == nullptr) {
    shift = {&candidate, residual, true};
    return;
  }
  const double a = shift.candidate->fit.offset, b = candidate.fit.offset;
  if (std::abs(a - b) < kSameShift) return;
  const bool alike = residual < kAlike * shift.residual && shift.residual < kAlike * residual;
  const bool near = std::min(std::abs(a), std::abs(b)) < kNearShift;
  const bool better = alike ? std::abs(b) < std::abs(a) : residual < shift.residual;
  if (better) {
    shift = {&candidate, residual, !alike || near};
  } else if (alike && !near) {
    shift.clear = false;
  }
}

Shift explained_by(const Trial& trial, std::size_t reading, const Eigen::Matrix3d& R) {
  Shift shift;
  for (const Candidate& candidate : trial.candidates) {
    if (candidate.reading != reading) continue;
    if (const auto r = trial.residual(candidate, R)) offer(candidate, *r, shift);
  }
  return shift;
}

// With any rotation. Only whole readings: w first differs from the inverse by a rotation.
Shift explained_freely(const Trial& trial) {
  Shift shift;
  for (const Candidate& candidate : trial.candidates) {
    const TurningFit& fit = candidate.fit;
    const TruthReading reading = kReadings[candidate.reading];
    if (!trial.only && is_w_first(reading)) continue;
    if (fit.unexplained() > kMostUnexplained || fit.residual > kAlike * trial.best) continue;
    offer(candidate, fit.residual, shift);
  }
  return shift;
}

TurningExplanation explained(const Shift& shift, const KnownFrame* frame, bool other_frame) {
  return {.reading = kReadings[shift.candidate->reading],
          .frame = frame,
          .other_frame = other_frame,
          .clock_is_clear = shift.clear,
          .fit = shift.candidate->fit,
          .residual = shift.residual};
}

// Whether the rotation between the axes of the IMU and those of the truth is well determined and no
// small one.
bool turned(const TurningFit& fit) {
  const double angle = so3::log(fit.reference_R_truth).norm();
  return fit.rotation_sigma < kDetermined && angle > truth_limits::kOtherAxes &&
         angle > truth_limits::kTurnSigmas * fit.rotation_sigma;
}

// The frames of two cameras may differ by less than what still explains the rates.
std::optional<TurningExplanation> best_frame(const Trial& trial, std::size_t reading,
                                             const std::vector<KnownFrame>& frames) {
  std::optional<TurningExplanation> best;
  for (const KnownFrame& frame : frames) {
    const Shift shift = explained_by(trial, reading, frame.imu_T_frame.R);
    if (shift.candidate == nullptr || (best && best->residual <= shift.residual)) continue;
    best = explained(shift, &frame, false);
  }
  return best;
}

std::optional<TurningExplanation> choose(const Trial& trial,
                                         const std::vector<KnownFrame>& frames) {
  for (std::size_t reading = 0; reading < kReadings.size(); ++reading) {
    const Shift same = explained_by(trial, reading, Eigen::Matrix3d::Identity());
    if (same.candidate != nullptr) {
      return explained(same, nullptr, turned(same.candidate->fit));
    }
    // Both faults and a camera are less likely than the axes of a marker.
    if (kReadings[reading] == TruthReading::kWFirstInverse && !trial.only) continue;
    if (const auto of_frame = best_frame(trial, reading, frames)) return of_frame;
  }
  const Shift free = explained_freely(trial);
  if (free.candidate == nullptr) return std::nullopt;
  return explained(free, nullptr, turned(free.candidate->fit));
}

// Between its stamps an interpolated truth has less noise, which draws the offset half way to the
// next one, by the share that noise has of the squares. It is in no score.
double noise_sigma(const TurningFit& fit, const Trajectory& truth) {
  const double share = fit.unexplained() * fit.unexplained();
  return 2 * share * to_seconds(median_spacing(truth));
}

// A clock that is off leaves more on the other side of zero, where the stamps are as far.
bool shows_its_offset(const Trial& trial, const TurningExplanation& e) {
  const double offset = e.fit.offset;
  const std::size_t reading =
      static_cast<std::size_t>(std::ranges::find(kReadings, e.reading) - kReadings.begin());
  const Trajectory& truth = trial.truths[reading];
  const double nearest = 2 * to_seconds(median_spacing(truth));
  if (std::abs(offset) < truth_limits::kLeastOffset || std::abs(offset) > nearest) return true;
  const auto left = [&](double shift) {
    return turning_residual(trial.windows, truth, shift, e.fit.reference_R_truth, trial.options);
  };
  return left(offset) < kOtherSide * left(-offset);
}

TurningEvidence explain_windows(const TruthReference& reference, const Trajectory& truth, Time gap,
                                double length, std::optional<TruthReading> only) {
  TurningEvidence evidence;
  Trial trial{.windows = rate_windows(reference.poses, from_seconds(length)),
              .options = {.gap = gap, .biased = reference.biased},
              .only = only.has_value()};
  for (std::size_t i = 0; i < kReadings.size(); ++i) {
    trial.truths[i] = read_as(kReadings[i], truth);
  }
  for (const Lag& lag :
       find_lags(reference.poses, truth, SpeedKind::kTurning, reference.biased, gap)) {
    for (std::size_t i = 0; i < kReadings.size(); ++i) {
      if (only && kReadings[i] != *only) continue;
      const auto fit = fit_turning(trial.windows, trial.truths[i], lag.offset, trial.options);
      if (!fit || fit->signal < kLeastSignal) continue;
      trial.candidates.push_back({i, *fit});
      trial.best = std::min(trial.best, fit->residual);
      evidence.unexplained = std::min(evidence.unexplained, fit->unexplained());
      evidence.unlike = evidence.unlike || fit->windows >= kWindowsOfUnlike;
    }
  }
  if (std::isfinite(trial.best)) evidence.explanation = choose(trial, reference.frames);
  if (evidence.explanation) {
    TurningFit& fit = evidence.explanation->fit;
    fit.offset_sigma = std::hypot(fit.offset_sigma, noise_sigma(fit, truth));
    if (!shows_its_offset(trial, *evidence.explanation))
      evidence.explanation->clock_is_clear = false;
  }
  evidence.unlike = evidence.unlike && evidence.unexplained > truth_limits::kUnlike;
  return evidence;
}

}  // namespace

bool is_w_first(TruthReading reading) {
  return reading == TruthReading::kWFirst || reading == TruthReading::kWFirstInverse;
}

bool is_inverse(TruthReading reading) {
  return reading == TruthReading::kInverse || reading == TruthReading::kWFirstInverse;
}

Eigen::Matrix3d read_as(TruthReading reading, const Eigen::Matrix3d& R) {
  if (reading == TruthReading::kAsRead) return R;
  if (reading == TruthReading::kInverse) return R.transpose();
  // Eigen's constructor takes w first.
  const Eigen::Quaterniond q(R);
  const Eigen::Matrix3d w_first = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix();
  return is_inverse(reading) ? w_first.transpose() : w_first;
}

Trajectory read_as(TruthReading reading, Trajectory truth) {
  for (StampedPose& row : truth) row.pose.R = read_as(reading, row.pose.R);
  return truth;
}

TurningEvidence explain_turning(const TruthReference& reference, const Trajectory& truth, Time gap,
                                std::optional<TruthReading> only) {
  const double spacing =
      to_seconds(std::max(median_spacing(reference.poses), median_spacing(truth)));
  TurningEvidence evidence;
  for (const double length : kWindowLengths) {
    const TurningEvidence one =
        explain_windows(reference, truth, gap, std::max(spacing, length), only);
    if (one.explanation) return one;
    if (one.unexplained == kNothingCompared) continue;
    const bool first = evidence.unexplained == kNothingCompared;
    evidence.unlike = one.unlike && (first || evidence.unlike);
    evidence.unexplained = std::min(evidence.unexplained, one.unexplained);
  }
  return evidence;
}

}  // namespace chasles
