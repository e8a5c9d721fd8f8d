#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/data/csv.hpp>

namespace chasles {

/// Where a table of one sensor has its values, and what makes them SI units.
struct SensorColumns {
  std::size_t time = 0;
  std::string time_unit = {};         ///< as it stands in the heading, in small letters
  std::array<std::size_t, 3> axes{};  ///< x, y, z
  double scale = 1;                   ///< to m/s^2 or rad/s
  std::string unit = {};              ///< of the axes, where it is another one
};

/// By the names in the first line. `accelerometer`: or gyroscope. Throws InputError with the names
/// for a table without a time or three axes, or with several that may be meant.
SensorColumns sensor_columns(const CsvReader& csv, bool accelerometer);

/// The time of a row.
Time sensor_time(const CsvReader& csv, const SensorColumns& columns);

/// The text with commas between the values, if its first line with names has none: between
/// semicolons, tabs or blanks.
std::string with_commas(std::string text);

}  // namespace chasles
