#include <algorithm>
#include <cmath>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/eval/truth_forms.hpp>
#include <chasles/eval/truth_interpolation.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>

namespace chasles {
namespace {

constexpr double kMostOffsetSigma = 0.05;  // [s]
constexpr double kAlikePositions = 1.3;    // of the rms of two shifts
// Of the ATE and of the attitudes that are left, what a clock must reach.
constexpr double kBetter = 0.9, kBetterAttitudes = 0.8;
constexpr double kBetterInertial = 0.95, kBetterAttitudesInertial = 0.95;
constexpr double kAtAllBetter = 0.99, kVeryManySigmas = 8;
constexpr double kSpread = 0.02;  // of the breadth, for a tilt by positions

void take_reading(TruthWork& work, const TurningEvidence& evidence) {
  work.turning = evidence.explanation;
  if (!work.turning) return;
  const TurningFit& fit = work.turning->fit;
  if (work.turning->clock_is_clear && fit.offset_sigma < kMostOffsetSigma) {
    work.result.clock = {.offset = fit.offset, .sigma = fit.offset_sigma, .by_rotations = true};
  }
  work.mended = read_as(work.turning->reading, work.truth);
}

// What the best rotations leave of the attitudes: between the worlds alone, with other axes on the
// body, or in the world of the positions.
std::optional<AttitudeFit> best_attitudes(const TruthWork& work) {
  std::vector<AttitudeFitOptions> trials(3, {.offset = work.offset(), .gap = work.gap});
  trials[1].body = trials[2].body = true;
  const auto path =
      fit_path(work.estimate, work.truth, {.start_offset = work.offset(), .gap = work.gap});
  if (path) trials[2].truth_R_estimate = path->truth_T_estimate.R;
  std::optional<AttitudeFit> best;
  for (const AttitudeFitOptions& trial : trials) {
    const auto fit = fit_attitudes(work.reference.poses, work.truth, trial);
    if (fit && (!best || fit->rms < best->rms)) best = fit;
  }
  return best;
}

void examine_unexplained(TruthWork& work, const TurningEvidence& evidence) {
  if (work.turning) return;
  const auto fit = work.reference.biased ? std::nullopt : best_attitudes(work);
  const bool turns = fit && fit->excursion > unlike_attitudes_limit(*fit);
  if (turns && fit->rms < unlike_attitudes_limit(*fit)) return;  // the rates are noise
  if (evidence.unlike) {
    work.find(unlike_finding(work.reference, evidence.unexplained));
  } else if (turns) {
    work.find(unlike_attitudes_finding(work.reference, *fit));
  }
}

// Inverse poses have other positions than inverse rotations.
bool is_whole(const TruthWork& work, const std::vector<FormFit>& fits) {
  const TruthReading reading = work.turning->reading;
  for (const FormFit& fit : fits) {
    if (fit.form.reading == reading && fit.form.whole) return true;
  }
  if (!work.reference.positions) return false;
  const PositionFitOptions options{.start_offset = work.offset(), .gap = work.gap};
  const auto as_read = fit_path(work.estimate, work.truth, options);
  const auto inverse = fit_path(work.estimate, in_form({reading, true}, work.truth), options);
  return inverse &&
         (!as_read || inverse->rms / inverse->extent < 0.5 * as_read->rms / as_read->extent);
}

// The reading by the rates, unless the positions contradict it.
void read_attitudes(TruthWork& work) {
  const TurningEvidence evidence = explain_turning(work.reference, work.truth, work.gap);
  take_reading(work, evidence);
  std::vector<FormFit> fits;
  if (work.reference.positions)
    fits = fit_forms(work.estimate, work.truth, work.offset(), work.gap);
  const auto by_rates = work.turning ? std::optional(work.turning->reading) : std::nullopt;
  const auto other = contradicting_form(fits, by_rates);
  if (other && work.turning) {
    take_reading(work, explain_turning(work.reference, work.truth, work.gap, other->reading));
  }
  examine_unexplained(work, evidence);
  if (!work.turning) return;
  const TruthReading reading = work.turning->reading;
  const bool whole = is_inverse(reading) && is_whole(work, fits);
  if (whole) work.mended = in_form({reading, true}, work.truth);
  if (is_w_first(reading)) work.find(w_first_finding(work.reference, *work.turning));
  if (is_inverse(reading)) work.find(inverse_finding(work.reference, *work.turning, whole));
}

// Where no rotation tells it, the positions give the clock: of several shifts that fit alike the
// one near zero, or none.
void clock_by_positions(TruthWork& work) {
  if (work.result.clock || !work.reference.positions) return;
  std::vector<PositionFit> fits;
  for (const Lag& lag :
       find_lags(work.estimate, work.mended, SpeedKind::kMoving, false, work.gap)) {
    const PositionFitOptions options{.offset = true, .start_offset = lag.offset, .gap = work.gap};
    const auto one = fit_path(work.estimate, work.mended, options);
    if (is_of_one_path(one) && one->offset_sigma < kMostOffsetSigma) fits.push_back(*one);
  }
  if (fits.empty()) return;
  const double best = std::ranges::min_element(fits, {}, &PositionFit::rms)->rms;
  std::erase_if(fits, [&](const PositionFit& one) { return one.rms > kAlikePositions * best; });
  const auto size = [](const PositionFit& one) { return std::abs(one.offset); };
  const PositionFit fit = *std::ranges::min_element(fits, {}, size);
  const bool clear = std::ranges::none_of(fits, [&](const PositionFit& other) {
    return std::abs(other.offset - fit.offset) > kSameShift;
  });
  if (!clear && size(fit) > kNearShift) return;
  work.result.clock = {.offset = fit.offset, .sigma = fit.offset_sigma};
}

BeforeAndAfter attitudes_by_clock(const TruthWork& work, double offset) {
  if (!work.result.attitudes) return {};
  const auto rms = [&](double shift) -> std::optional<double> {
    const auto fit =
        fit_attitudes(work.reference.poses, work.mended, {.offset = shift, .gap = work.gap});
    return fit ? std::optional(fit->rms) : std::nullopt;
  };
  return {rms(0), rms(offset)};
}

bool is_better(const BeforeAndAfter& figure, double share) {
  return figure.after && (!figure.before || *figure.after <= share * *figure.before);
}

// A clock that is certain shows in the positions or in the attitudes. Held velocities make the
// attitudes of an estimate late by half of their interval, so that those alone must show it well.
bool clock_matters(const TruthWork& work, const BeforeAndAfter& ate,
                   const BeforeAndAfter& attitudes) {
  if (is_better(ate, kBetter) || is_better(attitudes, kBetterAttitudes)) return true;
  if (work.reference.level != true) return false;
  if (is_better(ate, kBetterInertial) || is_better(attitudes, kBetterAttitudesInertial))
    return true;
  const TruthClock& clock = *work.result.clock;
  return std::abs(clock.offset) > kVeryManySigmas * clock.sigma &&
         is_better(attitudes, kAtAllBetter);
}

void examine_clock(TruthWork& work) {
  if (!work.result.clock) return;
  const TruthClock& clock = *work.result.clock;
  const double least = work.reference.positions ? truth_limits::kLeastOffset
                                                : truth_limits::kLeastOffsetWithoutPositions;
  if (std::abs(clock.offset) <= std::max(least, truth_limits::kManySigmas * clock.sigma)) return;
  if (!work.reference.positions) {
    work.find(clock_finding(work.reference, clock, least, {}, {}));
    return;
  }
  const BeforeAndAfter ate{aligned_rms(work.estimate, work.mended, 0, work.gap),
                           aligned_rms(work.estimate, work.mended, clock.offset, work.gap)};
  const BeforeAndAfter attitudes = attitudes_by_clock(work, clock.offset);
  if (!clock_matters(work, ate, attitudes)) return;
  work.find(clock_finding(work.reference, clock, least, ate, attitudes));
}

// Few stamps of the truth are near those of the estimate, and nothing lies between them.
void examine_spacing(TruthWork& work) {
  const Time spacing = median_spacing(work.truth);
  const Time longest = work.options.gap;
  if (!work.options.interpolated || !work.reference.positions || spacing <= longest) return;
  if (spacing <= 2 * median_spacing(work.reference.poses)) return;
  work.find(sparse_finding(to_seconds(spacing), to_seconds(longest)));
}

// Of what is compared, as it is.
void examine_interpolation(TruthWork& work) {
  if (!work.options.interpolated || !work.reference.positions) return;
  if (median_spacing(work.truth) <= median_spacing(work.reference.poses)) return;
  const InterpolationError error =
      interpolation_error(work.reference.poses, work.truth, work.options.gap);
  if (error.share < 0.5) return;
  const auto ate = aligned_rms(work.estimate, work.mended, work.offset(), work.gap);
  const BeforeAndAfter attitudes = attitudes_by_clock(work, work.offset());
  const double share = truth_limits::kInterpolationShare;
  const bool positions = ate && error.position > share * *ate;
  const bool turns = attitudes.after && error.attitude > share * *attitudes.after;
  if (!positions && !turns) return;
  work.find(interpolated_finding(error, to_seconds(median_spacing(work.truth))));
}

// truth_R_reference of the worlds, by the attitudes, or else by the positions if they spread
// enough.
std::optional<Eigen::Matrix3d> between_worlds(const TruthWork& work) {
  if (!work.turning) {
    if (work.result.attitudes || !is_of_one_path(work.path)) return std::nullopt;
    const bool spread = world_sigma(*work.path) < kSpread;
    return spread ? std::optional(work.path->truth_T_estimate.R) : std::nullopt;
  }
  const auto fit =
      fit_attitudes(work.reference.poses, work.mended, {.offset = work.offset(), .gap = work.gap});
  return fit ? std::optional(fit->truth_R_estimate) : std::nullopt;
}

void examine_tilt(TruthWork& work) {
  if (work.reference.biased || work.reference.level == false || work.options.levelled) return;
  const auto truth_R_reference = between_worlds(work);
  if (!truth_R_reference) return;
  const Eigen::Vector3d up = truth_R_reference->col(2);
  const double tilt = std::atan2(up.head<2>().norm(), up.z());
  if (tilt > (work.reference.level ? truth_limits::kTilt : truth_limits::kTiltOfUnknown)) {
    work.find(tilt_finding(work.reference, up, tilt));
  }
}

}  // namespace

TruthExamination examine_truth(const TruthReference& reference, const Trajectory& truth,
                               const TruthExaminationOptions& options) {
  TruthWork work{.reference = reference,
                 .truth = truth,
                 .options = options,
                 .mended = truth,
                 .estimate = reference.poses};
  if (truth.size() < 3 || reference.poses.size() < 3) return work.result;
  work.gap = std::max(options.gap, 3 * median_spacing(truth) / 2);
  work.result.attitudes = !options.positions_only && !is_without_attitudes(reference.poses, truth);
  if (!work.result.attitudes) {
    work.find(positions_only_finding(reference, truth.size(), options.positions_only));
  } else {
    read_attitudes(work);
    frame_by_rates(work);
  }
  clock_by_positions(work);
  examine_path(work);
  if (work.result.attitudes) frame_by_positions(work);
  examine_clock(work);
  examine_spacing(work);
  examine_interpolation(work);
  report_frame(work);
  examine_tilt(work);
  return work.result;
}

}  // namespace chasles
