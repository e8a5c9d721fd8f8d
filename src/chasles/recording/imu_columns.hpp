#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/codec/csv.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/time_text.hpp>

namespace chasles {

/// Where the time of a row is.
struct TimeColumn {
  std::size_t column = 0;
  std::optional<TimeScale> scale = {};       ///< as the name states it
  std::optional<std::size_t> fraction = {};  ///< the column of nanoseconds beside whole seconds
  std::optional<std::size_t> other = {};     ///< a column that is a time as well, and not taken
};

/// The column of times: the names of this program and of EuRoC, Kalibr and ROS first, then others
/// such as `__time`, `Time (s)`, `timestamp_us` or `header.stamp.secs` with `header.stamp.nsecs`.
/// Of several of the former the first one of a list counts: time_ns, the message's stamp,
/// timestamp, time. A unit may stand in brackets or at the end of the name. Throws InputError
/// without one, and for units of times that are not read.
TimeColumn find_time_column(const CsvReader& csv);
/// The same; nothing without one.
std::optional<TimeColumn> time_column(const CsvReader& csv);

/// The columns of an IMU table.
struct ImuColumns {
  TimeColumn time;
  VectorColumns rate, force;
  /// Columns gx, gy, gz beside other angular rates: the direction of gravity of a phone's fusion.
  std::optional<VectorColumns> gravity = {};
  /// Whether the names of `rate` are those of something derived (est_gyro_x, rx): if gx, gy, gz are
  /// no gravity, they are the rates.
  bool rate_is_derived = false;
};

/// The three numbers of the row that `csv` is at, in SI units.
Eigen::Vector3d vector_of(const CsvReader& csv, const VectorColumns& columns);

/// Finds the columns by their names, in any order. Throws InputError for names that are not known
/// or are there twice, and for units that are not rates or forces.
ImuColumns find_imu_columns(const CsvReader& csv);

/// The axes of a table of one sensor: the only three columns that differ in x, y and z, whatever
/// their names; else those named x, y, z or as that sensor's. Throws InputError without them, if
/// several may be meant or are another sensor's, and as with_unit().
VectorColumns find_sensor_axes(const CsvReader& csv, ImuQuantity quantity);

/// Throws InputError: the columns of a table of one sensor are not as expected.
[[noreturn]] void fail_sensor_columns(const CsvReader& csv, const std::string& found);

}  // namespace chasles
