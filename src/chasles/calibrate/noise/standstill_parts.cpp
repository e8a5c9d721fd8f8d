#include <algorithm>
#include <cmath>
#include <utility>

#include <chasles/base/median.hpp>
#include <chasles/calibrate/noise/standstill_parts.hpp>
#include <chasles/check/check_imu.hpp>

namespace chasles {
namespace {

constexpr double kHighestRate = 200;  // [Hz]
constexpr double kTrim = 0.5;         // [s]
constexpr double kTouchWindow = 0.5;  // [s]
constexpr double kTouchFactor = 3;

// Which samples of a span are of a standstill.
using Mask = std::vector<char>;

std::size_t samples_of_mean(const EvenSpan& span) {
  return static_cast<std::size_t>(std::max(1.0, std::floor(1 / (kHighestRate * span.period))));
}

// At most 200 means a second: the limits of a standstill are those of the scatter at such rates.
std::vector<ImuSample> means_of(const EvenSpan& span) {
  const std::size_t size = samples_of_mean(span);
  std::vector<ImuSample> means(span.count() / size);
  for (std::size_t i = 0; i < means.size(); ++i) {
    ImuSample& mean = means[i];
    mean.time = span.begin + from_seconds(span.period * static_cast<double>(i * size));
    for (std::size_t k = i * size; k < (i + 1) * size; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis);
        mean.specific_force_imu[row] += span.signals[axis][k] / static_cast<double>(size);
        mean.angular_rate_imu[row] += span.signals[axis + 3][k] / static_cast<double>(size);
      }
    }
  }
  return means;
}

std::size_t samples_in(const EvenSpan& span, double seconds) {
  return static_cast<std::size_t>(std::max(2.0, std::round(seconds / span.period)));
}

Mask standing_still(const EvenSpan& span, double& longest) {
  Mask mask(span.count(), 0);
  for (const StandstillSpan& still : find_standstills(means_of(span))) {
    longest = std::max(longest, to_seconds(still.end - still.begin));
    const auto index = [&](Time time) {
      return static_cast<std::size_t>(std::lround(to_seconds(time - span.begin) / span.period));
    };
    std::size_t from = index(still.begin), to = index(still.end) + samples_of_mean(span);
    const std::size_t trim = samples_in(span, kTrim);
    if (from > 0) from += trim;
    // A last window that is not full belongs to no standstill.
    if (to + trim < span.count()) to -= std::min(to, trim);
    for (std::size_t i = from; i < std::min(to, span.count()); ++i) mask[i] = 1;
  }
  return mask;
}

// Root of the three axes' variance.
double scatter(const EvenSpan& span, std::size_t first_axis, std::size_t from, std::size_t to) {
  const auto n = static_cast<double>(to - from);
  double sum = 0;
  for (std::size_t axis = first_axis; axis < first_axis + 3; ++axis) {
    const std::vector<double>& x = span.signals[axis];
    double mean = 0;
    for (std::size_t i = from; i < to; ++i) mean += x[i] / n;
    for (std::size_t i = from; i < to; ++i) sum += (x[i] - mean) * (x[i] - mean) / n;
  }
  return std::sqrt(sum);
}

// Calls visit(mask, from, to, force scatter, rate scatter) for each window of a standstill.
template <typename Visitor>
void for_each_window(std::span<const EvenSpan> spans, std::vector<Mask>& masks, Visitor&& visit) {
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const std::size_t window = samples_in(spans[s], kTouchWindow);
    for (std::size_t from = 0; from < spans[s].count(); from += window) {
      const std::size_t to = std::min(from + window, spans[s].count());
      const auto at = [&](std::size_t i) {
        return masks[s].begin() + static_cast<std::ptrdiff_t>(i);
      };
      if (std::find(at(from), at(to), 1) == at(to)) continue;
      visit(masks[s], from, to, scatter(spans[s], 0, from, to), scatter(spans[s], 3, from, to));
    }
  }
}

void leave_out_touches(std::span<const EvenSpan> spans, std::vector<Mask>& masks) {
  std::vector<double> forces, rates;
  for_each_window(spans, masks, [&](Mask&, std::size_t, std::size_t, double force, double rate) {
    forces.push_back(force);
    rates.push_back(rate);
  });
  if (forces.empty()) return;
  const double most_force = kTouchFactor * median(forces), most_rate = kTouchFactor * median(rates);
  for_each_window(spans, masks,
                  [&](Mask& mask, std::size_t from, std::size_t to, double force, double rate) {
                    if (force <= most_force && rate <= most_rate) return;
                    for (std::size_t i = from; i < to; ++i) mask[i] = 0;
                  });
}

}  // namespace

StandstillParts find_standstill_parts(std::span<const EvenSpan> spans) {
  StandstillParts parts;
  std::vector<Mask> masks;
  for (const EvenSpan& span : spans) masks.push_back(standing_still(span, parts.longest));
  leave_out_touches(spans, masks);
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const EvenSpan& span = spans[s];
    for (std::size_t from = 0, to = 0; from < span.count(); from = to) {
      while (to < span.count() && masks[s][to] == masks[s][from]) ++to;
      if (to - from < 2) continue;
      const EvenSpan part = part_of(span, from, to);
      if (masks[s][from] == 0) {
        parts.motion.push_back(part);
      } else if (part.seconds() >= kShortestStandstill) {
        parts.standstill.push_back(part);
      }
    }
  }
  return parts;
}

}  // namespace chasles
