#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/time_text.hpp>

namespace chasles {
namespace {

constexpr TimeScale kNanoseconds{"nanoseconds", 0}, kMicroseconds{"microseconds", 3},
    kMilliseconds{"milliseconds", 6}, kSeconds{"seconds", 9};
constexpr std::array kScales{kSeconds, kMilliseconds, kMicroseconds, kNanoseconds};
constexpr double kCoarseStep = 1e5;  // of times that get a remark [ns]

using ScaleName = std::pair<std::string_view, TimeScale>;
constexpr std::array kScaleNames{ScaleName{"s", kSeconds},
                                 ScaleName{"sec", kSeconds},
                                 ScaleName{"secs", kSeconds},
                                 ScaleName{"second", kSeconds},
                                 ScaleName{"seconds", kSeconds},
                                 ScaleName{"ms", kMilliseconds},
                                 ScaleName{"msec", kMilliseconds},
                                 ScaleName{"millis", kMilliseconds},
                                 ScaleName{"millisec", kMilliseconds},
                                 ScaleName{"milliseconds", kMilliseconds},
                                 ScaleName{"us", kMicroseconds},
                                 ScaleName{"usec", kMicroseconds},
                                 ScaleName{"\u00b5s", kMicroseconds},
                                 ScaleName{"\u03bcs", kMicroseconds},
                                 ScaleName{"micros", kMicroseconds},
                                 ScaleName{"microsec", kMicroseconds},
                                 ScaleName{"microseconds", kMicroseconds},
                                 ScaleName{"ns", kNanoseconds},
                                 ScaleName{"nsec", kNanoseconds},
                                 ScaleName{"nsecs", kNanoseconds},
                                 ScaleName{"nanos", kNanoseconds},
                                 ScaleName{"nanosec", kNanoseconds},
                                 ScaleName{"nanosecs", kNanoseconds},
                                 ScaleName{"nanoseconds", kNanoseconds}};

// digits * 10^exponent.
struct Decimal {
  bool negative = false;
  std::string digits;  // without leading zeros
  int exponent = 0;
};

std::optional<Decimal> parse_decimal(std::string_view text) {
  constexpr std::size_t kLongest = 64;
  Decimal value;
  if (text.empty() || text.size() > kLongest) return std::nullopt;
  if (text.front() == '-' || text.front() == '+') {
    value.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  const std::size_t e = std::min(text.find_first_of("eE"), text.size());
  if (e + 1 < text.size()) {
    std::string_view power = text.substr(e + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    const auto [stop, error] =
        std::from_chars(power.data(), power.data() + power.size(), value.exponent);
    if (error != std::errc() || stop != power.data() + power.size()) return std::nullopt;
  } else if (e < text.size()) {
    return std::nullopt;
  }
  text = text.substr(0, e);
  const std::size_t point = std::min(text.find('.'), text.size());
  value.digits = std::string(text.substr(0, point));
  if (point < text.size()) {
    value.digits += text.substr(point + 1);
    value.exponent -= static_cast<int>(text.size() - point - 1);
  }
  const bool valid = !value.digits.empty() && std::abs(value.exponent) < 1000 &&
                     value.digits.find_first_not_of("0123456789") == std::string::npos;
  if (!valid) return std::nullopt;
  value.digits.erase(0, std::min(value.digits.find_first_not_of('0'), value.digits.size()));
  return value;
}

Time nanoseconds_of(std::string_view text, const std::function<std::string(std::size_t)>& where,
                    std::size_t i) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  const bool read =
      error == std::errc() && stop == end && value > -kLastNanosecond && value < kLastNanosecond;
  return read ? Time(value) : parse_nanoseconds(where(i), text);
}

bool is_whole_number(std::string_view text) {
  return text.find_first_of(".eE") == std::string_view::npos;
}

// "0.1 ms".
std::string step_text(double nanoseconds) {
  if (nanoseconds >= 1e9) return fmt::format("{:g} s", nanoseconds / 1e9);
  if (nanoseconds >= 1e5) return fmt::format("{:g} ms", nanoseconds / 1e6);
  if (nanoseconds >= 1e3) return fmt::format("{:g} us", nanoseconds / 1e3);
  return fmt::format("{:g} ns", nanoseconds);
}

// The smallest step between two times that allows as many of them.
double mean_interval(std::vector<Time> times) {
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  return static_cast<double>((*last - *first).count()) / static_cast<double>(times.size() - 1);
}

void check_steps(const ColumnTimes& column, std::string_view text, const std::string& where) {
  if (column.times.size() < 4) return;
  const double interval = mean_interval(column.times);
  if (column.step <= 1.5 * interval) return;
  throw InputError(fmt::format(
      "{}: the times are written as '{}', with steps of {}, and {} rows are within {}: they do not "
      "distinguish the rows. Did a spreadsheet round them? Export the table again with all digits, "
      "without opening it there",
      where, text, step_text(column.step), column.times.size(),
      step_text(interval * static_cast<double>(column.times.size() - 1))));
}

std::vector<WrittenTime> in_scale(const std::vector<std::string_view>& texts,
                                  const TimeScale& scale,
                                  const std::function<std::string(std::size_t)>& where) {
  std::vector<WrittenTime> times;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto time = written_time(texts[i], scale);
    if (!time) {
      throw InputError(fmt::format("{}: found '{:.40}', expected a time in {} up to the year 2115",
                                   where(i), texts[i], scale.name));
    }
    times.push_back(*time);
  }
  return times;
}

// The first unit, from the longest on, in which the largest time can be read.
TimeScale scale_of(const std::vector<std::string_view>& texts) {
  for (const TimeScale& scale : kScales) {
    const bool fits = std::ranges::all_of(texts, [&](std::string_view text) {
      const auto decimal = parse_decimal(text);
      return !decimal || written_time(text, scale).has_value();
    });
    if (fits) return scale;
  }
  return kNanoseconds;
}

ColumnTimes whole_nanoseconds(const std::vector<std::string_view>& texts,
                              const std::function<std::string(std::size_t)>& where) {
  ColumnTimes result{.times = {}, .scale = kNanoseconds, .step = 1};
  for (std::size_t i = 0; i < texts.size(); ++i) {
    result.times.push_back(nanoseconds_of(texts[i], where, i));
  }
  return result;
}

ColumnTimes decimal_times(const std::vector<std::string_view>& texts, const TimeScale& scale,
                          const std::function<std::string(std::size_t)>& where) {
  ColumnTimes result{.times = {}, .scale = scale, .step = 0};
  const std::vector<WrittenTime> written = in_scale(texts, scale, where);
  for (const WrittenTime& time : written) result.times.push_back(time.time);
  result.step = std::ranges::min_element(written, {}, &WrittenTime::step)->step;
  return result;
}

// As nanoseconds, decimals do not distinguish rows.
bool is_of_another_unit(const ColumnTimes& column) {
  return column.times.size() >= 4 && column.step < 1 && mean_interval(column.times) < 1;
}

}  // namespace

std::optional<TimeScale> time_scale_named(std::string_view name) {
  const auto* found = std::ranges::find(kScaleNames, name, &ScaleName::first);
  return found == kScaleNames.end() ? std::nullopt : std::optional(found->second);
}

std::optional<WrittenTime> written_time(std::string_view text, const TimeScale& scale) {
  constexpr int kMostDigits = 19;  // of 64 bits
  const auto decimal = parse_decimal(text);
  if (!decimal) return std::nullopt;
  const int count = static_cast<int>(decimal->digits.size());
  const int exponent = decimal->exponent + scale.digits;
  const double step = std::pow(10.0, exponent);
  if (count == 0) return WrittenTime{.time = Time::zero(), .step = step};
  if (count + exponent > kMostDigits) return std::nullopt;
  std::string whole = decimal->digits.substr(
      0, static_cast<std::size_t>(std::max(0, std::min(count, count + exponent))));
  whole.append(static_cast<std::size_t>(std::max(0, exponent)), '0');
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (!whole.empty() && error != std::errc()) return std::nullopt;
  const int next = count + exponent;  // the digit after the nanoseconds
  if (next >= 0 && next < count && decimal->digits[static_cast<std::size_t>(next)] >= '5') ++value;
  if (value >= kLastNanosecond) return std::nullopt;
  return WrittenTime{.time = Time(decimal->negative ? -value : value), .step = step};
}

ColumnTimes read_unscaled_times(const std::vector<std::string_view>& texts,
                                const std::function<std::string(std::size_t)>& where) {
  if (std::ranges::all_of(texts, is_whole_number)) return whole_nanoseconds(texts, where);
  ColumnTimes result = decimal_times(texts, scale_of(texts), where);
  check_steps(result, texts.back(), where(texts.size() - 1));
  return result;
}

ColumnTimes read_nanoseconds(const std::vector<std::string_view>& texts,
                             const std::function<std::string(std::size_t)>& where) {
  if (std::ranges::all_of(texts, is_whole_number)) return whole_nanoseconds(texts, where);
  ColumnTimes result = decimal_times(texts, kNanoseconds, where);
  if (is_of_another_unit(result)) return read_unscaled_times(texts, where);
  check_steps(result, texts.back(), where(texts.size() - 1));
  return result;
}

void check_stated_scale(const ColumnTimes& column, std::string_view first,
                        const std::string& where) {
  constexpr double kLeastInterval = 5e4;  // [ns]
  if (column.times.size() < 100) return;
  const double interval = mean_interval(column.times);
  if (interval == 0 || interval >= kLeastInterval) return;
  throw InputError(fmt::format(
      "{}: the name states {}, and the times begin with '{:.40}': so {} rows are within {}, at "
      "{:.3g} Hz, expected at most 20000. Correct the unit behind the name, as in `time [s]`",
      where, column.scale.name, first, column.times.size(),
      step_text(interval * static_cast<double>(column.times.size() - 1)), 1e9 / interval));
}

bool rounded_to_15_digits(const std::vector<Time>& times) {
  constexpr std::int64_t kFifteenDigits = 1'000'000'000'000'000;
  bool coarser = true, further = true;
  for (const Time time : times) {
    std::int64_t unit = 1;
    while (std::abs(time.count()) / unit >= kFifteenDigits) unit *= 10;
    if (unit == 1 || time.count() % unit != 0) coarser = false;
    if (time.count() % (10 * unit) != 0) further = false;
  }
  return times.size() >= 10 && coarser && !further;
}

std::string times_remark(const std::string& file, const ColumnTimes& column) {
  if (column.times.empty() || (column.scale.digits == 0 && column.step < kCoarseStep)) return {};
  const std::string taken = fmt::format("{}: the times are taken as {}", file, column.scale.name);
  if (column.step < kCoarseStep) return taken;
  const double interval = column.times.size() > 1 ? mean_interval(column.times) : 0;
  return fmt::format("{}: their digits make steps of {}, and rows are {} apart", taken,
                     step_text(column.step), step_text(interval));
}

}  // namespace chasles
