#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <chasles/constants.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/eval/truth_reading.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kLeastSignal = 0.02;  // [rad/s]
constexpr double kMostUnexplained = 0.35;
constexpr double kUnlike = 0.8;      // of the signal, unexplained
constexpr double kMisaligned = 0.1;  // sine of the angle that still counts as the same axes
constexpr double kSurely = 5;        // sigmas
constexpr double kOtherAxes = 3 * kRadians, kDetermined = 1 * kRadians;
constexpr std::size_t kWindowsOfUnlike = 40;

constexpr std::array kReadings{TruthReading::kAsRead, TruthReading::kWFirst,
                               TruthReading::kInverse};

// What the candidates are compared by.
struct Trial {
  std::vector<RateWindow> windows;
  TurningOptions options;
  std::array<Trajectory, 3> truths = {};
  std::array<std::optional<TurningFit>, 3> fits = {};
  double best = 0;  // residual [rad/s]

  bool explains(std::size_t reading, const Eigen::Matrix3d& R) const {
    const auto& fit = fits[reading];
    if (!fit || fit->unexplained() > kMostUnexplained) return false;
    const double r = turning_residual(windows, truths[reading], fit->offset, R, options);
    const double allowed = kMisaligned * fit->signal;
    return r * r <= best * best + allowed * allowed;
  }
};

TurningExplanation explained(const Trial& trial, std::size_t reading, const KnownFrame* frame,
                             bool other_frame) {
  return {.reading = kReadings[reading],
          .frame = frame,
          .other_frame = other_frame,
          .fit = *trial.fits[reading]};
}

// Whether the rotation between the axes of the IMU and those of the truth is well determined and no
// small one.
bool turned(const TurningFit& fit) {
  const double angle = so3::log(fit.reference_R_truth).norm();
  return fit.rotation_sigma < kDetermined && angle > kOtherAxes &&
         angle > kSurely * fit.rotation_sigma;
}

std::optional<TurningExplanation> choose(const Trial& trial,
                                         const std::vector<KnownFrame>& frames) {
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
  for (std::size_t reading = 0; reading < kReadings.size(); ++reading) {
    if (trial.explains(reading, same)) {
      return explained(trial, reading, nullptr, turned(*trial.fits[reading]));
    }
    for (const KnownFrame& frame : frames) {
      if (trial.explains(reading, frame.imu_T_frame.R)) {
        return explained(trial, reading, &frame, false);
      }
    }
  }
  for (const std::size_t reading : {std::size_t{0}, std::size_t{2}}) {
    const auto& fit = trial.fits[reading];
    if (!fit || fit->unexplained() > kMostUnexplained) continue;
    if (fit->residual > 1.5 * trial.best) continue;
    return explained(trial, reading, nullptr, true);
  }
  return std::nullopt;
}

}  // namespace

Eigen::Matrix3d read_as(TruthReading reading, const Eigen::Matrix3d& R) {
  if (reading == TruthReading::kInverse) return R.transpose();
  if (reading == TruthReading::kAsRead) return R;
  // Eigen's constructor takes w first.
  const Eigen::Quaterniond q(R);
  return Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix();
}

Trajectory read_as(TruthReading reading, Trajectory truth) {
  for (StampedPose& row : truth) row.pose.R = read_as(reading, row.pose.R);
  return truth;
}

TurningEvidence explain_turning(const TruthReference& reference, const Trajectory& truth,
                                Time gap) {
  TurningEvidence evidence;
  const Time spacing = std::max(median_spacing(reference.poses), median_spacing(truth));
  Trial trial{.windows = rate_windows(reference.poses, std::max(spacing, Time(100'000'000))),
              .options = {.gap = gap, .biased = reference.biased}};
  const auto lag = find_lag(reference.poses, truth, SpeedKind::kTurning, reference.biased, gap);
  trial.best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kReadings.size(); ++i) {
    trial.truths[i] = read_as(kReadings[i], truth);
    trial.fits[i] =
        fit_turning(trial.windows, trial.truths[i], lag ? lag->offset : 0, trial.options);
    const auto& fit = trial.fits[i];
    if (!fit || fit->signal < kLeastSignal) continue;
    trial.best = std::min(trial.best, fit->residual);
    evidence.unexplained = std::min(evidence.unexplained, fit->unexplained());
    evidence.unlike = evidence.unlike || fit->windows >= kWindowsOfUnlike;
  }
  if (std::isfinite(trial.best)) evidence.explanation = choose(trial, reference.frames);
  evidence.unlike = evidence.unlike && evidence.unexplained > kUnlike;
  return evidence;
}

}  // namespace chasles
