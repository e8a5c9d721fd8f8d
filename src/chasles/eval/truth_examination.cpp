#include <cmath>
#include <vector>

#include <chasles/eval/association.hpp>
#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/eval/truth_forms.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>

namespace chasles {
namespace {

constexpr double kSpread = 0.02;  // of the breadth, for a tilt by positions

void take_reading(TruthWork& work, const TurningEvidence& evidence) {
  work.turning = evidence.explanation;
  if (!work.turning) return;
  const TurningFit& fit = work.turning->fit;
  if (work.turning->clock_is_clear && fit.offset_sigma < truth_limits::kMostOffsetSigma) {
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
  const PositionFitOptions options{.scale = true, .start_offset = work.offset(), .gap = work.gap};
  const Trajectory inverted = in_form({reading, true}, work.truth);
  const auto fits_better = [](const auto& inverse, const auto& as_read) {
    return inverse &&
           (!as_read || inverse->rms / inverse->extent < 0.5 * as_read->rms / as_read->extent);
  };
  // First without a point on the body: where a path is short, one far away explains either.
  const auto as_read = fit_positions(work.estimate, work.truth, options);
  const auto inverse = fit_positions(work.estimate, inverted, options);
  if (is_of_one_path(as_read) || is_of_one_path(inverse)) return fits_better(inverse, as_read);
  return fits_better(fit_path(work.estimate, inverted, options),
                     fit_path(work.estimate, work.truth, options));
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
