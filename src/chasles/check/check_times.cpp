#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/check/check_times.hpp>

namespace chasles {
namespace {

constexpr double kGap = 1.5;  // of the median interval
constexpr double kMissingShare = 0.01;
constexpr double kJitter = 0.2;     // of the median interval
constexpr double kRegular = 0.04;   // of an interval of which nine in ten are multiples
constexpr int kMostParts = 8;       // of the median
constexpr double kUnbroken = 0.08;  // share of the intervals between which nothing is lost
constexpr std::size_t kFewestOfStream = 12;

double at_part(std::vector<double>& values, double part) {
  const auto nth = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
}

double multiple_of(double interval, double base) {
  return std::max(1.0, std::round(interval / base));
}

// How far nine in ten intervals are from a multiple of `base`.
double off_multiples(const std::vector<double>& intervals, double base) {
  std::vector<double> off;
  for (const double i : intervals) off.push_back(std::abs(i - multiple_of(i, base) * base));
  return at_part(off, 0.9);
}

// The interval of which the others are multiples, if frames are lost at random; 0: there is none.
double lossy_interval(const std::vector<double>& intervals, double median) {
  if (intervals.size() < kFewestOfStream) return 0;
  for (int parts = 1; parts <= kMostParts; ++parts) {
    double base = median / parts, sum = 0, count = 0, unbroken = 0;
    for (const double i : intervals) {
      if (i > kMostParts * median) continue;  // a gap that is long shows little of the interval
      sum += i;
      count += multiple_of(i, base);
      unbroken += multiple_of(i, base) == 1 ? 1 : 0;
    }
    if (count > 0) base = sum / count;
    if (unbroken < kUnbroken * static_cast<double>(intervals.size())) continue;
    if (off_multiples(intervals, base) < kRegular * base) return base;
  }
  return 0;
}

void report_disorder(const TimesCheck& times, const std::string& about, CheckReport& report) {
  const auto count = [&](std::size_t found, const char* how) {
    if (found == 0) return;
    report.findings.push_back({.severity = Severity::kWarning,
                               .about = about,
                               .what = fmt::format("{} of {} stamps {}", found, times.count, how),
                               .value = static_cast<double>(found),
                               .threshold = 0,
                               .unit = "stamps",
                               .advice = "check the driver: a filter drops late data"});
  };
  count(times.late, "lie before an earlier one");
  count(times.repeated, "repeat the one before");
}

void report_gaps(const TimesCheck& times, const TimesLimits& limits, const std::string& about,
                 CheckReport& report) {
  // A stream that is slow throughout has no gap.
  if (times.longest > std::max(limits.interval, kGap * times.interval)) {
    report.findings.push_back(
        {.severity = Severity::kWarning,
         .about = about,
         .what = fmt::format("nothing for {:.3f} s, from {:.2f} s on", times.longest,
                             times.longest_after),
         .value = times.longest,
         .threshold = limits.interval,
         .unit = "s",
         .advice = "expect a larger uncertainty after the gap, or cut the recording there"});
  }
  const double all = static_cast<double>(times.count + times.missing);
  const double share = static_cast<double>(times.missing) / all;
  if (share <= kMissingShare) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what = fmt::format("{:.1f} % seem to be lost{}, in {} gaps", 100 * share,
                           times.lossy ? " at random" : "", times.gaps),
       .value = 100 * share,
       .threshold = 100 * kMissingShare,
       .unit = "%",
       .advice = "record to a faster disk, or over a link that does not drop"});
}

void report_jitter(const TimesCheck& times, const std::string& about, CheckReport& report) {
  if (times.jitter <= kJitter * times.interval) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what = fmt::format("the stamps jitter by {:.1f} ms around an interval of {:.1f} ms",
                           1e3 * times.jitter, 1e3 * times.interval),
       .value = 1e3 * times.jitter,
       .threshold = 1e3 * kJitter * times.interval,
       .unit = "ms",
       .advice = "use the device's own stamps instead of arrival times"});
}

}  // namespace

TimesCheck check_times(const std::vector<Time>& stamps) {
  TimesCheck check{.count = stamps.size()};
  std::vector<double> intervals;
  Time latest = stamps.empty() ? Time{} : stamps.front();
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    check.late += stamps[i] < latest ? 1 : 0;
    check.repeated += stamps[i] == latest ? 1 : 0;
    if (stamps[i] <= latest) continue;
    intervals.push_back(to_seconds(stamps[i] - latest));
    if (intervals.back() > check.longest) {
      check.longest = intervals.back();
      check.longest_after = to_seconds(latest - stamps.front());
    }
    latest = stamps[i];
  }
  if (intervals.empty()) return check;
  check.interval = at_part(intervals, 0.5);
  std::vector<double> off;
  for (const double interval : intervals) off.push_back(std::abs(interval - check.interval));
  check.jitter = at_part(off, 0.9);
  const double base =
      check.jitter > kJitter * check.interval ? lossy_interval(intervals, check.interval) : 0;
  if (base > 0) {
    check.lossy = true;
    check.interval = base;
    check.jitter = off_multiples(intervals, base);
  }
  for (const double interval : intervals) {
    if (interval <= kGap * check.interval) continue;
    ++check.gaps;
    check.missing += static_cast<std::size_t>(std::lround(interval / check.interval)) - 1;
  }
  return check;
}

void report_times(const TimesCheck& times, const TimesLimits& limits, const std::string& about,
                  CheckReport& report) {
  report.facts.push_back({about, "count", static_cast<double>(times.count), ""});
  report_disorder(times, about, report);
  if (times.interval <= 0) return;
  report.facts.push_back({about, "rate", 1 / times.interval, "Hz"});
  report.facts.push_back({about, "jitter", 1e3 * times.jitter, "ms"});
  report.facts.push_back({about, "longest interval", 1e3 * times.longest, "ms"});
  report_gaps(times, limits, about, report);
  report_jitter(times, about, report);
}

}  // namespace chasles
