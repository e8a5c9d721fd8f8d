#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/column_names.hpp>
#include <chasles/data/imu_columns.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr std::array<std::string_view, 9> kTimeNames{
    "time_ns", "timestamp", "timestamp_ns", "timestamps",        "ts",
    "t",       "time",      "stamp",        "field.header.stamp"};
// Others, the better ones first: the stamp of the sensor comes before the time of recording.
constexpr std::array<std::string_view, 17> kTimeWords{
    "header_stamp", "sensor_timestamp", "sensor_time",  "timestamp", "time_stamp", "stamp",
    "time",         "unix_time",        "unixtime",     "epoch",     "epoch_time", "rostime",
    "elapsed",      "elapsed_time",     "time_elapsed", "t",         "ts"};

// A name without a unit behind it, which it returns as well.
std::pair<std::string, std::optional<TimeScale>> time_name(const std::string& words) {
  const auto [before, last] = last_word(words);
  const auto scale = time_scale_named(last);
  if (!scale) return {words, std::nullopt};
  return {before.empty() ? "time" : before, scale};  // `seconds` and `sec` are times
}

bool is_fraction_name(const std::string& word) {
  const auto scale = time_scale_named(word);
  return scale && scale->digits == 0 && word != "ns";
}

// header.stamp.secs and header.stamp.nsecs.
std::optional<TimeColumn> seconds_and_nanoseconds(const CsvReader& csv, bool of_stamp) {
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    const auto [before, last] = last_word(column_words(csv, i));
    const auto scale = time_scale_named(last);
    const bool stamp = before.ends_with("stamp");
    if (!scale || scale->digits != 9 || stamp != of_stamp) continue;
    for (std::size_t j = 0; j < csv.columns().size(); ++j) {
      const auto [other, fraction] = last_word(column_words(csv, j));
      if (other == before && is_fraction_name(fraction)) {
        return TimeColumn{.column = i, .scale = scale, .fraction = j};
      }
    }
  }
  return std::nullopt;
}

// Where names end with the words of an entry; the first entry that finds one counts.
std::optional<TimeColumn> time_by_words(const CsvReader& csv) {
  for (const std::string_view known : kTimeWords) {
    const bool any_before = known.size() > 2;
    const auto found = only_column(csv, "the time", [&](std::size_t i) {
      const std::string name = time_name(column_words(csv, i)).first;
      return name == known || (any_before && ends_in_word(name, known));
    });
    if (found)
      return TimeColumn{.column = *found, .scale = time_name(column_words(csv, *found)).second};
  }
  return std::nullopt;
}

std::optional<TimeScale> stated_scale(const CsvReader& csv, std::size_t column) {
  const std::string unit = bracketed_unit(csv, column);
  if (unit.empty()) return std::nullopt;
  const auto scale = time_scale_named(unit);
  if (scale || csv.headings()[column].find('[') == std::string::npos) return scale;
  throw InputError(fmt::format(
      "{}: the unit of {} is {}, expected a time in ns, us, ms or s up to the year 2115",
      csv.where(), csv.columns()[column], unit));
}

}  // namespace

TimeColumn find_time_column(const CsvReader& csv) {
  if (const auto pair = seconds_and_nanoseconds(csv, true)) return *pair;
  TimeColumn found;
  const auto exact = only_column(csv, "the time", [&](std::size_t i) {
    const std::string name = lower_case(csv.columns()[i]);
    return std::ranges::find(kTimeNames, std::string_view(name)) != kTimeNames.end();
  });
  if (exact) {
    found.column = *exact;
  } else if (const auto pair = seconds_and_nanoseconds(csv, false)) {
    return *pair;
  } else if (const auto other = time_by_words(csv)) {
    found = *other;
  } else {
    unknown_columns(csv, "the time");
  }
  if (const auto scale = stated_scale(csv, found.column)) found.scale = scale;
  // The digits decide between nanoseconds and seconds under the name time_ns.
  if (found.scale && found.scale->digits == 0) found.scale.reset();
  return found;
}

}  // namespace chasles
