#include <chasles/eval/association.hpp>
#include <chasles/eval/truth_interpolation.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>

namespace chasles {

void examine_spacing(TruthWork& work) {
  const Time spacing = median_spacing(work.truth);
  const Time longest = work.options.gap;
  if (!work.options.interpolated || !work.reference.positions || spacing <= longest) return;
  if (spacing <= 2 * median_spacing(work.reference.poses)) return;
  work.find(sparse_finding(to_seconds(spacing), to_seconds(longest)));
}

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

}  // namespace chasles
