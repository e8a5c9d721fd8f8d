#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/check/check_times.hpp>

namespace chasles {
namespace {

constexpr double kGap = 1.5;  // of the median interval
constexpr double kMissingShare = 0.01;
constexpr double kJitter = 0.2;  // of the median interval

double at_part(std::vector<double>& values, double part) {
  const auto nth = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + nth, values.end());
  return values[static_cast<std::size_t>(nth)];
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
  if (times.longest > limits.interval) {
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
       .what = fmt::format("{:.1f} % seem to be lost, in {} gaps", 100 * share, times.gaps),
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
  for (double& interval : intervals) {
    if (interval > kGap * check.interval) {
      ++check.gaps;
      check.missing += static_cast<std::size_t>(std::lround(interval / check.interval)) - 1;
    }
    interval = std::abs(interval - check.interval);
  }
  check.jitter = at_part(intervals, 0.9);
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
