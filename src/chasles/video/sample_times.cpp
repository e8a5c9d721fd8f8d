#include <algorithm>
#include <cmath>

#include <chasles/base/median.hpp>
#include <chasles/video/sample_times.hpp>

namespace chasles {
namespace {

double seconds_between(const std::vector<VideoPicture>& pictures) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    intervals.push_back(to_seconds(pictures[i].time - pictures[i - 1].time));
  }
  return median(std::move(intervals));
}

double difference(std::uint64_t a, std::uint64_t b) {
  return a >= b ? static_cast<double>(a - b) : -static_cast<double>(b - a);
}

// The time between two samples of a block [us]: to the next payload's stamp, or as in the last
// block before that has a next payload.
double interval_in(const std::vector<SampleBlock>& blocks, std::size_t k) {
  const auto goes_on = [&](std::size_t i) {
    return i + 1 < blocks.size() && blocks[i].payload + 1 == blocks[i + 1].payload;
  };
  std::size_t from = k;
  while (from > 0 && !goes_on(from)) --from;
  if (!goes_on(from)) from = std::min(k, blocks.size() - 2);
  return difference(*blocks[from + 1].stamp, *blocks[from].stamp) /
         difference(blocks[from + 1].first, blocks[from].first);
}

// Of the only payload.
double interval_of_payload(const SampleBlock& block) {
  return to_seconds(block.duration) / static_cast<double>(block.count);
}

}  // namespace

Line fitted_line(const std::vector<double>& x, const std::vector<double>& y, double slope) {
  Line line{.slope = slope};
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.x0 += x[i] / n;
    line.y0 += y[i] / n;
  }
  double xx = 0, xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - line.x0) * (x[i] - line.x0);
    xy += (x[i] - line.x0) * (y[i] - line.y0);
  }
  if (xx > 0) line.slope = xy / xx;
  return line;
}

bool are_stamped(const std::vector<SampleBlock>& blocks) {
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    if (!blocks[k].stamp || (k > 0 && *blocks[k].stamp <= *blocks[k - 1].stamp)) return false;
  }
  return true;
}

std::optional<Line> clock_by_pictures(const std::vector<SampleBlock>& blocks,
                                      const std::vector<VideoPicture>& pictures) {
  constexpr double kMicrosecond = 1e-6, kLargestDrift = 0.01;
  if (blocks.empty() || !are_stamped(blocks) || blocks.front().first != 0 || pictures.size() < 2) {
    return std::nullopt;
  }
  const double samples = difference(blocks.back().first + blocks.back().count, 0);
  const double of_each = std::round(static_cast<double>(pictures.size()) / samples);
  if (of_each < 1) return std::nullopt;  // a sensor, and no sample of a picture
  std::vector<double> stamps, times;
  for (const SampleBlock& block : blocks) {
    const double number = of_each * difference(block.first, 0);
    if (number >= static_cast<double>(pictures.size())) break;
    stamps.push_back(difference(*block.stamp, 0));
    times.push_back(to_seconds(pictures[static_cast<std::size_t>(number)].time));
  }
  const Line clock = fitted_line(stamps, times, kMicrosecond);
  if (std::abs(clock.slope / kMicrosecond - 1) > kLargestDrift) return std::nullopt;
  const double most = seconds_between(pictures) / 2;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (std::abs(clock(stamps[i]) - times[i]) > most) return std::nullopt;
  }
  return clock;
}

std::vector<double> stamped_times(const std::vector<SampleBlock>& blocks, const Line& clock) {
  std::vector<double> times;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const SampleBlock& block = blocks[k];
    const double interval =
        blocks.size() > 1 ? interval_in(blocks, k) : interval_of_payload(block) / clock.slope;
    for (std::size_t i = 0; i < block.count; ++i) {
      const double stamp = difference(*block.stamp, 0) + interval * static_cast<double>(i);
      times.push_back(clock(stamp) - block.delay);
    }
  }
  return times;
}

std::vector<double> times_by_payloads(const std::vector<SampleBlock>& blocks) {
  // A sensor may begin late in the first payload, whose start then says nothing of it.
  const std::size_t from = blocks.size() > 2 ? 1 : 0;
  std::vector<double> numbers, begins, times;
  for (std::size_t k = from; k < blocks.size(); ++k) {
    numbers.push_back(difference(blocks[k].first, 0));
    begins.push_back(to_seconds(blocks[k].begin));
  }
  const Line line = fitted_line(numbers, begins, interval_of_payload(blocks.front()));
  for (const SampleBlock& block : blocks) {
    for (std::size_t i = 0; i < block.count; ++i) {
      times.push_back(line(difference(block.first + i, 0)) - block.delay);
    }
  }
  return times;
}

}  // namespace chasles
