#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/column_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/imu_columns.hpp>

namespace chasles {
namespace {

// The first one that is there counts.
constexpr std::array<std::string_view, 9> kTimeNames{"field.header.stamp",
                                                     "time_ns",
                                                     "timestamp_ns",
                                                     "timestamp",
                                                     "timestamps",
                                                     "time",
                                                     "t",
                                                     "ts",
                                                     "stamp"};
// Others, the better ones first: the stamp of the sensor comes before the time of recording.
constexpr std::array<std::string_view, 17> kTimeWords{
    "header_stamp", "sensor_timestamp", "sensor_time",  "timestamp", "time_stamp", "stamp",
    "time",         "unix_time",        "unixtime",     "epoch",     "epoch_time", "rostime",
    "elapsed",      "elapsed_time",     "time_elapsed", "t",         "ts"};

// A name without a unit behind it, which it returns as well: time_ms, time_since_start_in_ms.
std::pair<std::string, std::optional<TimeScale>> time_name(std::string words) {
  std::optional<TimeScale> scale;
  const auto [before, last] = last_word(words);
  if ((scale = time_scale_named(last))) words = before;
  if (words.ends_with("_in")) words.resize(words.size() - 3);
  if (const std::size_t at = words.find("_since_"); at != std::string::npos) words.resize(at);
  if (words.empty()) return {"time", scale};  // `seconds` and `sec` are times
  if (!scale && (scale = time_scale_named(words))) return {"time", scale};  // ms_since_boot
  return {words, scale};
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
  constexpr std::array<std::string_view, 10> kUnread{"min", "minutes", "h",     "hr",     "hours",
                                                     "d",   "days",    "ticks", "cycles", "frames"};
  const bool unread = std::ranges::find(kUnread, std::string_view(unit)) != kUnread.end() ||
                      csv.headings()[column].find('[') != std::string::npos;
  if (scale || !unread) return scale;
  throw InputError(fmt::format(
      "{}: the unit of {} is {}, expected a time in ns, us, ms or s up to the year 2115",
      csv.where(), csv.columns()[column], unit));
}

}  // namespace

std::optional<TimeColumn> time_column(const CsvReader& csv) {
  if (const auto pair = seconds_and_nanoseconds(csv, true)) return *pair;
  TimeColumn found;
  const std::vector<std::size_t> exact = columns_named(csv, {kTimeNames.begin(), kTimeNames.end()});
  if (exact.size() > 1 &&
      lower_case(csv.columns()[exact[0]]) == lower_case(csv.columns()[exact[1]])) {
    two_columns(csv, exact[0], exact[1], "the time");
  }
  if (!exact.empty()) {
    found.column = exact.front();
    // That the message's stamp comes before the time of recording is no choice.
    const bool stamp = lower_case(csv.columns()[exact[0]]) == kTimeNames.front();
    if (exact.size() > 1 && !stamp) found.other = exact[1];
    found.scale = time_name(column_words(csv, found.column)).second;
  } else if (const auto pair = seconds_and_nanoseconds(csv, false)) {
    return *pair;
  } else if (const auto other = time_by_words(csv)) {
    found = *other;
  } else {
    return std::nullopt;
  }
  if (const auto scale = stated_scale(csv, found.column)) found.scale = scale;
  return found;
}

TimeColumn find_time_column(const CsvReader& csv) {
  const auto found = time_column(csv);
  if (!found) unknown_columns(csv, "the time");
  return *found;
}

}  // namespace chasles
