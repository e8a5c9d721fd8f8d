#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/time_text.hpp>
#include <chasles/recording/table_times.hpp>

namespace chasles {
namespace {

using Where = std::function<std::string(std::size_t)>;

Time with_fraction(const CsvReader& csv, const TableTimes& times, std::size_t i,
                   const std::string& file, const std::string& where) {
  const std::string of_fraction = fmt::format("{}:{}: column '{}'", file, times.lines[i],
                                              csv.columns()[*times.column.fraction]);
  const Time fraction = parse_nanoseconds(of_fraction, times.fractions[i]);
  const Time whole = parse_seconds(where, times.texts[i]);
  if (fraction >= Time::zero() && fraction < std::chrono::seconds(1)) return whole + fraction;
  throw InputError(fmt::format("{}: is {}, expected nanoseconds below 1000000000", of_fraction,
                               fraction.count()));
}

Time time_in(const TimeScale& scale, std::string_view text, const std::string& where) {
  if (scale.digits == 9) return parse_seconds(where, text);
  if (const auto time = written_time(text, scale)) return time->time;
  throw InputError(
      fmt::format("{}: is {:.40} {}, expected a time in ns, us, ms or s up to the year 2115", where,
                  text, scale.name));
}

// The steps of the most precise time.
double least_step(const TableTimes& times, const TimeScale& scale) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::string_view text : times.texts) {
    if (const auto time = written_time(text, scale)) least = std::min(least, time->step);
  }
  return least;
}

ColumnTimes stated_times(const CsvReader& csv, const std::string& file, const TableTimes& times,
                         const Where& where) {
  const TimeScale& scale = *times.column.scale;
  if (scale.digits == 0) return read_nanoseconds(times.texts, where);
  ColumnTimes read{.times = {}, .scale = scale, .step = least_step(times, scale)};
  for (std::size_t i = 0; i < times.texts.size(); ++i) {
    read.times.push_back(times.column.fraction ? with_fraction(csv, times, i, file, where(i))
                                               : time_in(scale, times.texts[i], where(i)));
  }
  if (!times.texts.empty()) check_stated_scale(read, times.texts.front(), where(0));
  return read;
}

// Of a stated unit only times with decimals can be coarse without intention.
bool is_remarkable(const TableTimes& times, const ColumnTimes& read) {
  if (!times.column.scale || times.texts.empty()) return true;
  if (read.scale.digits != times.column.scale->digits) return true;
  return !times.column.fraction && times.texts.front().find('.') != std::string_view::npos &&
         read.step >= 1e5;
}

}  // namespace

void add_time(const CsvReader& csv, TableTimes& times) {
  times.texts.push_back(csv.text(times.column.column));
  if (times.column.fraction) times.fractions.push_back(csv.text(*times.column.fraction));
  times.lines.push_back(csv.line());
}

std::vector<Time> read_table_times(const CsvReader& csv, const std::string& file,
                                   const std::string& table, const TableTimes& times,
                                   std::vector<std::string>& remarks) {
  const auto where = [&](std::size_t i) {
    return fmt::format("{}:{}: column '{}'", file, times.lines[i],
                       csv.columns()[times.column.column]);
  };
  ColumnTimes read = times.column.scale ? stated_times(csv, file, times, where)
                                        : read_unscaled_times(times.texts, where);
  if (times.column.other) {
    remarks.push_back(fmt::format("{}: the times are those of {}, and {} is not read", table,
                                  csv.columns()[times.column.column],
                                  csv.columns()[*times.column.other]));
  }
  if (read.scale.digits == 0 && rounded_to_15_digits(read.times)) {
    remarks.push_back(fmt::format(
        "{}: the times are rounded to 15 digits, as spreadsheets do it: they have steps of 10 us",
        table));
  }
  if (!is_remarkable(times, read)) return std::move(read.times);
  std::string remark = times_remark(table, read);
  if (!remark.empty()) remarks.push_back(std::move(remark));
  return std::move(read.times);
}

}  // namespace chasles
