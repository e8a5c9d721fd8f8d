#include <algorithm>
#include <cmath>
#include <vector>

#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>

namespace chasles {
namespace {

constexpr double kAlikePositions = 1.3;  // of the rms of two shifts
// Of the ATE and of the attitudes that are left, what a clock must reach.
constexpr double kBetter = 0.9, kBetterAttitudes = 0.8;
constexpr double kBetterAttitudesInertial = 0.95;
constexpr double kAtAllBetter = 0.99, kVeryManySigmas = 8;

bool is_better(const BeforeAndAfter& figure, double share) {
  return figure.after && (!figure.before || *figure.after <= share * *figure.before);
}

// A clock that is certain shows in the positions or in the attitudes. Held velocities make the
// attitudes of an estimate late by half of their interval, so that those alone must show it well.
bool clock_matters(const TruthWork& work, const BeforeAndAfter& ate,
                   const BeforeAndAfter& attitudes) {
  if (is_better(ate, kBetter) || is_better(attitudes, kBetterAttitudes)) return true;
  if (work.reference.level != true) return false;
  if (is_better(attitudes, kBetterAttitudesInertial)) return true;
  const TruthClock& clock = *work.result.clock;
  return std::abs(clock.offset) > kVeryManySigmas * clock.sigma &&
         is_better(attitudes, kAtAllBetter);
}

}  // namespace

BeforeAndAfter attitudes_by_clock(const TruthWork& work, double offset) {
  if (!work.result.attitudes) return {};
  const auto rms = [&](double shift) -> std::optional<double> {
    const auto fit =
        fit_attitudes(work.reference.poses, work.mended, {.offset = shift, .gap = work.gap});
    return fit ? std::optional(fit->rms) : std::nullopt;
  };
  return {rms(0), rms(offset)};
}

void clock_by_positions(TruthWork& work) {
  if (work.result.clock || !work.reference.positions) return;
  std::vector<PositionFit> fits;
  for (const Lag& lag :
       find_lags(work.estimate, work.mended, SpeedKind::kMoving, false, work.gap)) {
    const PositionFitOptions options{.offset = true, .start_offset = lag.offset, .gap = work.gap};
    const auto one = fit_path(work.estimate, work.mended, options);
    if (is_of_one_path(one) && one->offset_sigma < truth_limits::kMostOffsetSigma)
      fits.push_back(*one);
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
  // Less noise between stamps is no better clock: the opposite offset has as little.
  BeforeAndAfter better = attitudes;
  const BeforeAndAfter opposite = attitudes_by_clock(work, -clock.offset);
  if (better.before && opposite.after) better.before = std::min(*better.before, *opposite.after);
  if (!clock_matters(work, ate, better)) return;
  work.find(clock_finding(work.reference, clock, least, ate, attitudes));
}

}  // namespace chasles
