#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/imu_units.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/sensor_table_columns.hpp>
#include <chasles/error.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {
namespace {

// The first one that a table has counts.
constexpr std::array<std::string_view, 12> kTableTimes{
    "time_ns", "timestamp_ns", "timestamp",      "timestamps",     "time",  "t",
    "ts",      "stamp",        "unix timestamp", "unix_timestamp", "epoch", "seconds_elapsed"};
constexpr std::array<std::string_view, 8> kForceStems{
    "a", "a_rs_s", "acc", "accel", "acceleration", "accelerometer", "linear_acceleration", "alpha"};
constexpr std::array<std::string_view, 8> kRateStems{
    "w", "w_rs_s", "g", "gyr", "gyro", "gyroscope", "angular_velocity", "omega"};

/// A column's name and unit, in small letters.
struct Heading {
  std::string name, unit;
};

std::string bare(std::string_view text) {
  const auto is_edge = [](char c) { return c == ' ' || c == '"' || c == '\t' || c == '\r'; };
  while (!text.empty() && is_edge(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_edge(text.back())) text.remove_suffix(1);
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

Heading heading_of(const std::string& text) {
  const std::size_t begin = text.find_first_of("[("), end = text.find_last_of("])");
  if (begin == std::string::npos || end == std::string::npos || end < begin) {
    return {.name = bare(text), .unit = {}};
  }
  return {.name = bare(text.substr(0, begin)),
          .unit = bare(text.substr(begin + 1, end - begin - 1))};
}

[[noreturn]] void fail_columns(const CsvReader& csv, const std::string& found) {
  throw InputError(fmt::format(
      "{}: has the columns {}: {}, expected a time and x, y and z of one sensor, as time_ns,x,y,z",
      csv.where(), fmt::join(csv.headings(), ","), found));
}

std::string without_separator(std::string stem) {
  while (!stem.empty() && std::string_view("_. -/").find(stem.back()) != std::string_view::npos) {
    stem.pop_back();
  }
  return stem;
}

using Triples = std::map<std::string, std::array<std::optional<std::size_t>, 3>>;

// Names that differ in their last letter, by what is before it.
Triples triples_of(const std::vector<Heading>& headings) {
  Triples all;
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const std::string& name = headings[i].name;
    if (name.empty() || name.back() < 'x' || name.back() > 'z') continue;
    auto& place = all[without_separator(name.substr(0, name.size() - 1))]
                     [static_cast<std::size_t>(name.back() - 'x')];
    if (!place) place = i;
  }
  std::erase_if(all, [](const auto& one) {
    return std::ranges::any_of(one.second, [](const auto& column) { return !column; });
  });
  return all;
}

std::array<std::size_t, 3> chosen_axes(const CsvReader& csv, const Triples& triples,
                                       bool accelerometer) {
  const auto& stems = accelerometer ? kForceStems : kRateStems;
  const auto known = [&](const auto& one) {
    return one.first.empty() || std::ranges::find(stems, one.first) != stems.end();
  };
  const auto count = triples.size() == 1 ? 1 : std::ranges::count_if(triples, known);
  if (count != 1)
    fail_columns(csv, count == 0 ? "no three are its axes" : "several may be its axes");
  const auto found = triples.size() == 1 ? triples.begin() : std::ranges::find_if(triples, known);
  return {*found->second[0], *found->second[1], *found->second[2]};
}

double scale_of(const CsvReader& csv, ImuQuantity quantity, const std::string& unit) {
  if (const auto factor = factor_of_unit(unit, quantity)) return *factor;
  throw InputError(fmt::format("{}: the unit of its axes is {}, expected {}: convert it",
                               csv.where(), unit,
                               quantity == ImuQuantity::kForce ? "m/s^2 or g" : "rad/s or deg/s"));
}

std::size_t time_of_table(const CsvReader& csv, const std::vector<Heading>& headings) {
  for (const std::string_view name : kTableTimes) {
    const auto found = std::ranges::find(headings, name, &Heading::name);
    if (found != headings.end()) return static_cast<std::size_t>(found - headings.begin());
  }
  fail_columns(csv, "none is a time");
}

double seconds_of(const std::string& unit) {
  if (unit == "s" || unit == "sec" || unit == "second" || unit == "seconds") return 1;
  if (unit == "ms" || unit == "millisec" || unit == "milliseconds") return 1e-3;
  if (unit == "us" || unit == "\u00b5s" || unit == "microsec" || unit == "microseconds")
    return 1e-6;
  return unit == "ns" || unit == "nanosec" || unit == "nanoseconds" ? 1e-9 : 0;
}

// Of the first line that is no comment.
std::size_t begin_of_rows(const std::string& text) {
  std::size_t begin = 0;
  while (begin < text.size() && (text[begin] == '#' || text[begin] == '\n')) {
    begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
  }
  return begin;
}

void add_with_commas(std::string_view line, bool semicolons, std::string& to) {
  if (line.starts_with('#')) {
    to += '#';
    line.remove_prefix(1);
  }
  bool begun = false, separated = false, in_unit = false;
  for (const char c : line) {
    const bool blank = c == ' ' || c == '\t' || c == '\r';
    in_unit = (in_unit || c == '[' || c == '(') && c != ']' && c != ')';
    if (semicolons ? c == ';' : blank && !in_unit) {
      if (semicolons) to += ',';
      separated = true;
      continue;
    }
    // A unit belongs to the name before it.
    const bool unit = c == '[' || c == '(';
    if (!semicolons && begun && separated && !unit) to += ',';
    if (c != '\r') to += c;
    begun = true;
    separated = false;
  }
}

}  // namespace

SensorColumns sensor_columns(const CsvReader& csv, bool accelerometer) {
  std::vector<Heading> headings;
  for (const std::string& text : csv.headings()) headings.push_back(heading_of(text));
  SensorColumns columns;
  columns.time = time_of_table(csv, headings);
  columns.time_unit = headings[columns.time].unit;
  columns.axes = chosen_axes(csv, triples_of(headings), accelerometer);
  const std::string& unit = headings[columns.axes[0]].unit;
  for (const std::size_t axis : columns.axes) {
    if (headings[axis].unit != unit) fail_columns(csv, "its axes have different units");
  }
  columns.scale = scale_of(csv, accelerometer ? ImuQuantity::kForce : ImuQuantity::kRate, unit);
  if (columns.scale != 1) columns.unit = unit;
  return columns;
}

Time sensor_time(const CsvReader& csv, const SensorColumns& columns) {
  const std::string_view text = csv.text(columns.time);
  const bool point = text.find('.') != std::string_view::npos;
  const double unit =
      columns.time_unit.empty() ? (point ? 1 : 1e-9) : seconds_of(columns.time_unit);
  if (unit == 1) return parse_seconds(csv.where(columns.time), text);
  if (unit == 1e-9 && !point) return csv.time(columns.time);
  const double value = csv.finite(columns.time);
  if (unit > 0 && std::abs(value * unit) < 1e-9 * static_cast<double>(kLastNanosecond)) {
    return from_seconds(value * unit);
  }
  throw InputError(
      fmt::format("{}: is {} {}, expected a time in ns, us, ms or s up to the year "
                  "2115",
                  csv.where(columns.time), text, columns.time_unit));
}

// A comment counts only as the line with the names, which is the last one before the rows.
std::string with_commas(std::string text) {
  const std::size_t data = begin_of_rows(text);
  const std::size_t end = std::min(text.find('\n', data), text.size());
  const std::string_view first = std::string_view(text).substr(data, end - data);
  if (first.find(',') != std::string_view::npos) return text;
  const bool semicolons = first.find(';') != std::string_view::npos;
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t stop = std::min(text.find('\n', begin), text.size());
    const bool comment = text[begin] == '#' &&
                         (stop + 1 < data || first.find_first_not_of("0123456789.+-eE;\t\r ") !=
                                                 std::string_view::npos);
    if (comment) {
      result += '#';
    } else {
      add_with_commas(std::string_view(text).substr(begin, stop - begin), semicolons, result);
    }
    if (stop < text.size()) result += '\n';
    begin = stop + 1;
  }
  return result;
}

}  // namespace chasles
