#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/time_spans.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewTimes = 4;
constexpr double kExact = 1e-6;  // of a double at present-day times [s]
constexpr double kFastestSensor = 20'000, kFastestCamera = 2'000;  // [Hz]
constexpr Time kSince1970 = std::chrono::seconds(946'684'800);     // 2000-01-01

/// The measurements of one sensor: their number, first and last time.
struct SensorSpan {
  std::string what;
  std::size_t count = 0;
  Time begin{}, end{};

  double seconds() const { return to_seconds(end - begin); }
  double rate() const {  // [Hz]
    return count > 1 && seconds() > 0 ? static_cast<double>(count - 1) / seconds() : 0;
  }
};

template <typename Rows>
SensorSpan span_of(const std::string& what, const Rows& rows) {
  if (rows.empty()) return {.what = what};
  return {.what = what, .count = rows.size(), .begin = rows.front().time, .end = rows.back().time};
}

SensorSpan frames_of(const Recording& r) {
  const std::size_t count = frame_count(r);
  if (count == 0) return {.what = "frames"};
  // Tracks and images are each in order of time.
  SensorSpan span{.what = "frames", .count = count, .begin = Time::max(), .end = Time::min()};
  for (std::size_t i = 0; i < count; ++i) {
    span.begin = std::min(span.begin, frame_time(r, i));
    span.end = std::max(span.end, frame_time(r, i));
  }
  return span;
}

// "1600000000.000 s (2020-09-13 12:26:40 UTC)" or "5.000 s (no date: since boot?)".
std::string instant_text(Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const std::string date =
      time < kSince1970 ? "no date: since boot, or since the start?"
                        : fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                                      fmt::gmtime(static_cast<std::time_t>(seconds.count())));
  return fmt::format("{:.3f} s ({})", to_seconds(time), date);
}

std::string span_text(const SensorSpan& span) {
  if (span.count == 0) return "no " + span.what;
  return fmt::format("{} {} from {} to {}", span.count, span.what, instant_text(span.begin),
                     instant_text(span.end));
}

/// Units that are taken for nanoseconds by mistake.
struct TimeUnit {
  const char* name;
  double nanoseconds;
};
constexpr std::array kTimeUnits{TimeUnit{"microseconds", 1e3}, TimeUnit{"milliseconds", 1e6},
                                TimeUnit{"seconds", 1e9}};

void check_rate(const std::string& where, const SensorSpan& span, const SensorSpan& other,
                double fastest) {
  const double rate = span.rate();
  if (rate <= fastest) return;
  std::string guess;
  for (const TimeUnit& unit : kTimeUnits) {
    if (!guess.empty() || rate / unit.nanoseconds > fastest) continue;
    guess = fmt::format(": are these {} (then {:.4g} Hz)? Multiply them by {:.0f}", unit.name,
                        rate / unit.nanoseconds, unit.nanoseconds);
  }
  throw InputError(
      fmt::format("{}: {}, at {:.4g} Hz, expected nanoseconds and at most {} Hz{} ({})", where,
                  span_text(span), rate, fastest, guess, span_text(other)));
}

// The unit in which `a` would overlap `b`, with about the same length; empty if there is none.
std::string unit_guess(const SensorSpan& a, const SensorSpan& b) {
  for (const TimeUnit& unit : kTimeUnits) {
    const double begin = to_seconds(a.begin) * unit.nanoseconds,
                 end = to_seconds(a.end) * unit.nanoseconds;
    const bool overlap = begin <= to_seconds(b.end) && to_seconds(b.begin) <= end;
    if (overlap && end - begin < 2 * b.seconds() && b.seconds() < 2 * (end - begin)) {
      return fmt::format("are the times of the {} {}, not nanoseconds? Multiply them by {:.0f}",
                         a.what, unit.name, unit.nanoseconds);
    }
  }
  return "";
}

std::string clock_guess(const SensorSpan& sensor, const SensorSpan& frames) {
  for (const auto& [a, b] : {std::pair(&sensor, &frames), std::pair(&frames, &sensor)}) {
    if (std::string guess = unit_guess(*a, *b); !guess.empty()) return guess;
  }
  for (const auto& [a, b] : {std::pair(&sensor, &frames), std::pair(&frames, &sensor)}) {
    if (a->begin < kSince1970 && b->begin >= kSince1970) {
      return fmt::format(
          "the clock of the {} counts since boot or start, that of the {} since 1970: stamp both "
          "by "
          "the same clock (the first times differ by {:.3f} s)",
          a->what, b->what, to_seconds(b->begin - a->begin));
    }
  }
  const double hours = to_seconds(frames.begin - sensor.begin) / 3600;
  const double quarters = std::round(hours * 4);
  if (quarters != 0 && std::abs(hours) < 15 && std::abs(hours * 4 - quarters) < 0.02) {
    return fmt::format("the difference is {:.2f} h: is one of them in local time?", quarters / 4);
  }
  return "are these of the same recording, and stamped by the same clock?";
}

// Whether one of the frames is within the sensor's span.
bool within(const Recording& r, const SensorSpan& sensor) {
  for (std::size_t i = 0; i < frame_count(r); ++i) {
    const Time time = frame_time(r, i);
    if (time >= sensor.begin && time <= sensor.end) return true;
  }
  return false;
}

// The step between 32-bit floating-point numbers of seconds at this time [s].
double float_step(Time time) {
  const auto seconds = static_cast<float>(std::abs(to_seconds(time)));
  const float next = std::nextafter(seconds, std::numeric_limits<float>::infinity());
  return static_cast<double>(next) - static_cast<double>(seconds);
}

// Why many rows have the same time. The times are in order, each once.
std::string repeats_guess(const std::vector<Time>& times) {
  if (times.size() == 1 && times[0] == Time{}) return "the driver did not set the stamps";
  const double of_float = float_step(times.back());
  bool rounded = of_float > 1e-4;
  for (const Time time : times) {
    const double seconds = to_seconds(time);
    const double step = std::round(seconds / of_float) * of_float;
    rounded = rounded && std::abs(seconds - step) < kExact;
  }
  if (rounded) {
    return fmt::format(
        "they were rounded to 32-bit floating-point seconds, whose steps are {:g} s "
        "there: write integers of nanoseconds",
        of_float);
  }
  return "were they rounded? Write integers of nanoseconds";
}

SensorSpan span_of(const NamedTimes& named) {
  return {.what = named.what,
          .count = named.times.size(),
          .begin = named.times.front(),
          .end = named.times.back()};
}

}  // namespace

void check_overlap(const std::string& where, const NamedTimes& a, const NamedTimes& b) {
  const SensorSpan first = span_of(a), second = span_of(b);
  if (first.begin <= second.end && second.begin <= first.end) return;
  throw InputError(fmt::format("{}: {}, and {}, expected both at the same time: {}", where,
                               span_text(first), span_text(second), clock_guess(first, second)));
}

void check_distinct(const std::string& where, const std::string& what, std::vector<Time> times) {
  const std::size_t all = times.size();
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (all < kFewTimes || 2 * times.size() >= all) return;
  throw InputError(fmt::format(
      "{}: {} {} have only {} different time{}, from {} to {}, expected the time of each: {}",
      where, all, what, times.size(), times.size() == 1 ? "" : "s", instant_text(times.front()),
      instant_text(times.back()), repeats_guess(times)));
}

void check_time_spans(const std::string& where, const Recording& recording) {
  const SensorSpan frames = frames_of(recording);
  const std::array sensors{span_of("IMU samples", recording.imu),
                           span_of("body velocities", recording.velocities)};
  for (const SensorSpan& sensor : sensors) check_rate(where, sensor, frames, kFastestSensor);
  check_rate(where, frames, sensors[recording.imu.empty() ? 1 : 0], kFastestCamera);
  for (const SensorSpan& sensor : sensors) {
    if (sensor.count == 0 || frames.count == 0 || within(recording, sensor)) continue;
    throw InputError(fmt::format("{}: {}, and {}, expected frames within them: {}", where,
                                 span_text(sensor), span_text(frames),
                                 clock_guess(sensor, frames)));
  }
}

}  // namespace chasles
