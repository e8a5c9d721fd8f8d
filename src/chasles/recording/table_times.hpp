#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/recording/imu_columns.hpp>

namespace chasles {

/// The times of a table as its rows state them. The texts are those of the reader, which must live
/// as long.
struct TableTimes {
  TimeColumn column;
  std::vector<std::string_view> texts = {};
  std::vector<std::string_view> fractions = {};  ///< nanoseconds beside whole seconds
  std::vector<int> lines = {};                   ///< of the rows, from 1
};

/// Adds the time of the row that `csv` is at.
void add_time(const CsvReader& csv, TableTimes& times);

/// The times of all rows: in the unit that the column states; else as read_unscaled_times(), whose
/// unit is one for all rows. `file` and `table` name it in errors and in remarks, which are on the
/// unit that was taken, on times whose digits make coarse steps, and on a second column of times.
///
/// Throws InputError with file, line and column for a text that is no time, for a stated unit in
/// which the rows are less than a nanosecond apart, and for digits that do not distinguish rows.
std::vector<Time> read_table_times(const CsvReader& csv, const std::string& file,
                                   const std::string& table, const TableTimes& times,
                                   std::vector<std::string>& remarks);

}  // namespace chasles
