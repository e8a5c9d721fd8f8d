#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// A unit of times in tables.
struct TimeScale {
  std::string_view name;  ///< "seconds"
  int digits = 0;         ///< 10^digits nanoseconds
};

/// The unit of a name such as s, sec, ms, us, µs, ns, nanosec or seconds, in small letters; none
/// for another name.
std::optional<TimeScale> time_scale_named(std::string_view name);

/// A time, and the step between two times that are written with as many digits.
struct WrittenTime {
  Time time{};
  double step = 0;  ///< [ns]
};

/// A decimal number, also with an exponent, as a time: exact, and rounded to the nanosecond. None
/// for other texts, and for times beyond kLastNanosecond (parse.hpp).
std::optional<WrittenTime> written_time(std::string_view text, const TimeScale& scale);

/// The times of a column whose unit is not stated.
struct ColumnTimes {
  std::vector<Time> times;
  TimeScale scale;
  double step = 0;  ///< of the most precise one [ns]
};

/// Reads times whose unit is not stated. Whole numbers are nanoseconds. A column with decimals or
/// exponents is in the unit that makes its largest time one before the year 2115, beginning with
/// seconds: 0.005 and 1403636583.26 are seconds, 1.40363658326e+18 is nanoseconds. `where(i)` names
/// the place of a text. Throws InputError for a text that is no number, and for times whose digits
/// do not distinguish most of them, as spreadsheets round them.
ColumnTimes read_unscaled_times(const std::vector<std::string_view>& texts,
                                const std::function<std::string(std::size_t)>& where);

/// Reads times that are stated to be nanoseconds, with decimals and exponents as well. Where the
/// rows are less than a nanosecond apart they are in another unit, as seconds below the head of
/// EuRoC: then as read_unscaled_times(). Throws InputError likewise.
ColumnTimes read_nanoseconds(const std::vector<std::string_view>& texts,
                             const std::function<std::string(std::size_t)>& where);

/// Throws InputError if times in the unit that the name of their column states are at more than
/// 20000 Hz: that unit is wrong. Fewer than 100 are not assessed.
void check_stated_scale(const ColumnTimes& times, std::string_view first, const std::string& where);

/// Whether all times are rounded to 15 significant digits, as spreadsheets do it, and no further.
bool rounded_to_15_digits(const std::vector<Time>& times);

/// "FILE: its times are taken as seconds: …, steps of …"; empty where there is nothing to say.
std::string times_remark(const std::string& file, const ColumnTimes& times);

}  // namespace chasles
