#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/gzip.hpp>
#include <chasles/data/imu_table.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

using Spellings = std::span<const std::string_view>;

constexpr std::array<std::string_view, 9> kTimeNames{
    "time_ns", "timestamp", "timestamp_ns", "timestamps",        "ts",
    "t",       "time",      "stamp",        "field.header.stamp"};
// Before the letter of the axis.
constexpr std::array<std::string_view, 15> kRateNames{"w",
                                                      "w_",
                                                      "w_rs_s_",
                                                      "omega",
                                                      "omega_",
                                                      "g",
                                                      "g_",
                                                      "gyro",
                                                      "gyro_",
                                                      "gyr_",
                                                      "gyroscope_",
                                                      "angular_velocity_",
                                                      "angular_velocity.",
                                                      "field.angular_velocity.",
                                                      "angular_rate_"};
constexpr std::array<std::string_view, 16> kForceNames{"a",
                                                       "a_",
                                                       "a_rs_s_",
                                                       "alpha",
                                                       "alpha_",
                                                       "acc",
                                                       "acc_",
                                                       "accel_",
                                                       "acceleration_",
                                                       "accelerometer_",
                                                       "linear_acceleration_",
                                                       "linear_acceleration.",
                                                       "field.linear_acceleration.",
                                                       "specific_force_",
                                                       "f",
                                                       "f_"};

std::string small(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// The unit in brackets behind a name; empty without one.
std::string unit_of(const CsvReader& csv, std::size_t column) {
  const std::string& heading = csv.headings()[column];
  const std::size_t begin = heading.find('['), end = heading.find(']');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return small(heading.substr(begin + 1, end - begin - 1));
}

[[noreturn]] void unknown_names(const CsvReader& csv, const std::string& missing) {
  throw InputError(fmt::format(
      "{}: has the columns {}, and none is {}: expected names as time_ns,wx,wy,wz,ax,ay,az or "
      "EuRoC's (angular rates in rad/s, specific forces in m/s^2)",
      csv.where(), fmt::join(csv.headings(), ","), missing));
}

// The column whose name is one of these with `axis` behind it.
std::size_t column_of(const CsvReader& csv, Spellings names, std::string_view axis,
                      const std::string& what) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < csv.columns().size(); ++i) {
    const std::string name = small(csv.columns()[i]);
    const auto same = [&](std::string_view known) {
      return name.size() == known.size() + axis.size() && name.starts_with(known) &&
             name.ends_with(axis);
    };
    if (!std::ranges::any_of(names, same)) continue;
    if (found) {
      throw InputError(fmt::format("{}: both {} and {} may be {}, expected one of them",
                                   csv.where(), csv.columns()[*found], csv.columns()[i], what));
    }
    found = i;
  }
  if (!found) unknown_names(csv, what);
  return *found;
}

using Axes = std::array<std::size_t, 3>;

Axes axes_of(const CsvReader& csv, Spellings names, std::string_view what,
             std::span<const std::string_view> foreign_units) {
  Axes columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    columns[i] = column_of(csv, names, axis, fmt::format("the {} about or along {}", what, axis));
    const std::string unit = unit_of(csv, columns[i]);
    for (const std::string_view foreign : foreign_units) {
      if (!unit.starts_with(foreign)) continue;
      throw InputError(fmt::format("{}: the unit of {} is {}, expected rad/s and m/s^2: convert it",
                                   csv.where(), csv.columns()[columns[i]], unit));
    }
  }
  return columns;
}

constexpr std::array<std::string_view, 2> kDegreeUnits{"deg", "\u00b0"};
constexpr std::array<std::string_view, 2> kGravities{"g", "mg"};

Eigen::Vector3d vector_of(const CsvReader& csv, const Axes& axes) {
  return {csv.number(axes[0]), csv.number(axes[1]), csv.number(axes[2])};
}

}  // namespace

std::size_t time_column(const CsvReader& csv) { return column_of(csv, kTimeNames, "", "the time"); }

Time time_at(const CsvReader& csv, std::size_t column) {
  const std::string unit = unit_of(csv, column);
  if (unit.empty() || unit == "ns") return csv.time(column);
  if (unit == "s" || unit == "sec") return parse_seconds(csv.where(column), csv.text(column));
  const std::int64_t factor = unit == "us" ? 1'000 : unit == "ms" ? 1'000'000 : 0;
  const std::int64_t value = csv.integer(column);
  if (factor > 0 && value > -kLastNanosecond / factor && value < kLastNanosecond / factor) {
    return Time(value * factor);
  }
  throw InputError(
      fmt::format("{}: is {} {}, expected a time in ns, us, ms or s up to the year 2115",
                  csv.where(column), value, unit));
}

std::vector<ImuSample> read_imu_table(const std::filesystem::path& file) {
  CsvReader csv(file.string(), read_plain_or_gzip(file));
  const std::size_t time = time_column(csv);
  const Axes rate = axes_of(csv, kRateNames, "angular rate", kDegreeUnits);
  const Axes force = axes_of(csv, kForceNames, "specific force", kGravities);
  std::vector<ImuSample> imu;
  while (csv.next()) {
    imu.push_back({.time = time_at(csv, time),
                   .specific_force_imu = vector_of(csv, force),
                   .angular_rate_imu = vector_of(csv, rate)});
  }
  return imu;
}

}  // namespace chasles
