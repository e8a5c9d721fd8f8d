#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/codec/gzip.hpp>
#include <chasles/recording/imu_columns.hpp>
#include <chasles/recording/imu_sense.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/table_times.hpp>

namespace chasles {
namespace {

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

void remark_on_units(const std::string& table, const ImuColumns& columns,
                     std::vector<std::string>& remarks) {
  std::vector<std::string> converted;
  if (columns.rate.factor != 1) converted.push_back("angular rates in " + columns.rate.unit);
  if (columns.force.factor != 1) converted.push_back("specific forces in " + columns.force.unit);
  if (converted.empty()) return;
  remarks.push_back(
      fmt::format("{} has {}: converted to SI units", table, fmt::join(converted, " and ")));
}

std::vector<ImuSample> samples_of(const std::filesystem::path& file, std::string bytes,
                                  std::vector<std::string>& remarks) {
  CsvReader csv = open_imu_table(file.string(), std::move(bytes));
  ImuColumns columns = find_imu_columns(csv);
  const std::string table = file.filename().string();
  std::vector<ImuSample> imu;
  std::vector<Eigen::Vector3d> gravity;
  TableTimes written{.column = columns.time};
  while (csv.next()) {
    ImuSample& sample = imu.emplace_back();
    sample.specific_force_imu = vector_of(csv, columns.force);
    sample.angular_rate_imu = vector_of(csv, columns.rate);
    if (columns.gravity) gravity.push_back(vector_of(csv, *columns.gravity));
    add_time(csv, written);
  }
  const std::vector<Time> times = read_table_times(csv, file.string(), table, written, remarks);
  for (std::size_t i = 0; i < imu.size(); ++i) imu[i].time = times[i];
  take_rates_of_g(csv, columns, gravity, imu, remarks);
  remark_on_units(table, columns, remarks);
  check_sense(csv, file.string(), columns, imu, gravity, remarks);
  return imu;
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
  return samples_of(file, read_plain_or_gzip(file), remarks);
}

std::vector<ImuSample> read_imu_table(const std::filesystem::path& file) {
  std::vector<std::string> ignored;
  return read_imu_table(file, ignored);
}

std::vector<ImuSample> read_whole_rows(const std::filesystem::path& file) {
  std::vector<std::string> ignored;
  std::string bytes = read_plain_or_gzip(file);
  bytes.resize(bytes.rfind('\n') + 1);  // npos + 1 is 0
  return samples_of(file, std::move(bytes), ignored);
}

}  // namespace chasles
