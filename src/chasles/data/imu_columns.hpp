#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <chasles/data/csv.hpp>
#include <chasles/data/imu_units.hpp>
#include <chasles/data/time_text.hpp>

namespace chasles {

/// Where the time of a row is.
struct TimeColumn {
  std::size_t column = 0;
  std::optional<TimeScale> scale = {};       ///< as the name states it, but for nanoseconds
  std::optional<std::size_t> fraction = {};  ///< the column of nanoseconds beside whole seconds
};

/// The column of times: the names of this program and of EuRoC, Kalibr and ROS first, then others
/// such as `__time`, `Time (s)`, `timestamp_us` or `header.stamp.secs` with `header.stamp.nsecs`.
/// A unit may stand in brackets or at the end of the name. Throws InputError without one.
TimeColumn find_time_column(const CsvReader& csv);

/// The columns of an IMU table.
struct ImuColumns {
  TimeColumn time;
  VectorColumns rate, force;
  /// Columns gx, gy, gz beside other angular rates: the direction of gravity of a phone's fusion.
  std::optional<VectorColumns> gravity = {};
};

/// Finds the columns by their names, in any order. Throws InputError for names that are not known
/// or are there twice, and for units that are not rates or forces.
ImuColumns find_imu_columns(const CsvReader& csv);

}  // namespace chasles
