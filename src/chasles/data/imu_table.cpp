#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/gzip.hpp>
#include <chasles/data/imu_columns.hpp>
#include <chasles/data/imu_sense.hpp>
#include <chasles/data/imu_table.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

Eigen::Vector3d vector_of(const CsvReader& csv, const VectorColumns& v) {
  const Eigen::Vector3d values(csv.number(v.columns[0]), csv.number(v.columns[1]),
                               csv.number(v.columns[2]));
  return v.factor == 1 ? values : Eigen::Vector3d(v.factor * values);
}

// The fields of sensor_msgs/Imu in the order of `ros2 topic echo --csv`.
const std::vector<std::string>& ros2_echo_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list{"header.stamp.sec", "header.stamp.nanosec", "header.frame_id"};
    for (const char* axis : {"x", "y", "z", "w"})
      list.push_back(fmt::format("orientation.{}", axis));
    const auto covariance = [&](const std::string& of) {
      for (int i = 0; i < 9; ++i) list.push_back(fmt::format("{}_covariance.{}", of, i));
    };
    covariance("orientation");
    for (const char* of : {"angular_velocity", "linear_acceleration"}) {
      for (const char* axis : {"x", "y", "z"}) list.push_back(fmt::format("{}.{}", of, axis));
      covariance(of);
    }
    return list;
  }();
  return names;
}

CsvReader open_imu_table(const std::string& file, std::string bytes) {
  if (!is_ros2_echo(bytes)) return {file, std::move(bytes)};
  return {file, std::move(bytes), CsvReader::NoHeading{}, ros2_echo_names()};
}

// The texts of a column of times, and the lines of their rows.
struct TimeTexts {
  std::vector<std::string_view> texts;
  std::vector<int> lines;
};

Time time_in_scale(const CsvReader& csv, const TimeColumn& column) {
  const std::string_view text = csv.text(column.column);
  if (column.fraction) {
    const Time fraction = csv.time(*column.fraction);
    const Time whole = parse_seconds(csv.where(column.column), text);
    if (fraction >= Time::zero() && fraction < std::chrono::seconds(1)) return whole + fraction;
    throw InputError(fmt::format("{}: is {}, expected nanoseconds below 1000000000",
                                 csv.where(*column.fraction), fraction.count()));
  }
  if (column.scale->digits == 9) return parse_seconds(csv.where(column.column), text);
  if (const auto time = written_time(text, *column.scale)) return time->time;
  throw InputError(
      fmt::format("{}: is {:.40} {}, expected a time in ns, us, ms or s up to the year 2115",
                  csv.where(column.column), text, column.scale->name));
}

// The steps of the most precise time.
double least_step(const TimeTexts& times, const TimeScale& scale) {
  double least = std::numeric_limits<double>::infinity();
  for (const std::string_view text : times.texts) {
    if (const auto time = written_time(text, scale)) least = std::min(least, time->step);
  }
  return least;
}

void set_times(const std::string& file, const std::string& table, const CsvReader& csv,
               const TimeColumn& column, const TimeTexts& written, std::vector<ImuSample>& imu,
               std::vector<std::string>& remarks) {
  const auto where = [&](std::size_t i) {
    return fmt::format("{}:{}: column '{}'", file, written.lines[i], csv.columns()[column.column]);
  };
  ColumnTimes times;
  if (column.scale) {
    for (const ImuSample& sample : imu) times.times.push_back(sample.time);
    times.scale = *column.scale;
    times.step = least_step(written, *column.scale);
    if (column.fraction || times.step < 1e5 || written.texts.empty() ||
        written.texts.front().find('.') == std::string_view::npos) {
      return;
    }
  } else {
    times = read_unscaled_times(written.texts, where);
    for (std::size_t i = 0; i < imu.size(); ++i) imu[i].time = times.times[i];
    if (times.scale.digits == 0 && rounded_to_15_digits(times.times)) {
      remarks.push_back(fmt::format(
          "{}: the times are rounded to 15 digits, as spreadsheets do it: they have steps of 10 us",
          table));
    }
  }
  if (std::string remark = times_remark(table, times); !remark.empty()) {
    remarks.push_back(std::move(remark));
  }
}

void remark_on_units(const std::string& table, const ImuColumns& columns,
                     std::vector<std::string>& remarks) {
  std::vector<std::string> converted;
  if (columns.rate.factor != 1) converted.push_back("angular rates in " + columns.rate.unit);
  if (columns.force.factor != 1) converted.push_back("specific forces in " + columns.force.unit);
  if (converted.empty()) return;
  remarks.push_back(
      fmt::format("{} has {}: converted to SI units", table, fmt::join(converted, " and ")));
}

}  // namespace

// Such rows have no line of names above them.
bool is_ros2_echo(std::string_view bytes) {
  const CsvHeading heading = find_heading(bytes);
  std::vector<std::string_view> values;
  split_values(heading.first, {.quotes = true}, values);
  return heading.names.empty() && values.size() == ros2_echo_names().size();
}

std::vector<ImuSample> read_imu_table(const std::filesystem::path& file,
                                      std::vector<std::string>& remarks) {
  CsvReader csv = open_imu_table(file.string(), read_plain_or_gzip(file));
  const ImuColumns columns = find_imu_columns(csv);
  const std::string table = file.filename().string();
  std::vector<ImuSample> imu;
  std::vector<Eigen::Vector3d> gravity;
  TimeTexts written;
  while (csv.next()) {
    ImuSample& sample = imu.emplace_back();
    sample.specific_force_imu = vector_of(csv, columns.force);
    sample.angular_rate_imu = vector_of(csv, columns.rate);
    if (columns.gravity) gravity.push_back(vector_of(csv, *columns.gravity));
    if (columns.time.scale) sample.time = time_in_scale(csv, columns.time);
    written.texts.push_back(csv.text(columns.time.column));
    written.lines.push_back(csv.line());
  }
  set_times(file.string(), table, csv, columns.time, written, imu, remarks);
  remark_on_units(table, columns, remarks);
  check_sense(csv, file.string(), columns, imu, gravity, remarks);
  return imu;
}

std::vector<ImuSample> read_imu_table(const std::filesystem::path& file) {
  std::vector<std::string> ignored;
  return read_imu_table(file, ignored);
}

}  // namespace chasles
