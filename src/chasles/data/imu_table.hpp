#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <chasles/data/csv.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The samples of an IMU table as people and programs write it, plain or gzip-compressed, in the
/// order of its rows. The names in the first line, which may be a comment, determine the columns,
/// in any order: this program's (time_ns,wx,…,az), EuRoC's (timestamp,w_RS_S_x,…), those of
/// kalibr_bagextractor (timestamp,omega_x,…,alpha_z), of `rostopic echo -p`, and similar ones.
/// Further columns are ignored. Numbers may be "nan" or "inf": tidy_samples() removes such samples.
/// Times are nanoseconds, or in the unit that stands in brackets behind the name: [ns], [us], [ms]
/// or [s].
///
/// Throws InputError with file, line and column: for names that are not known or are there twice,
/// and for units other than rad/s and m/s^2.
std::vector<ImuSample> read_imu_table(const std::filesystem::path& file);

/// The index of the column of times by the same names. Throws InputError without one.
std::size_t time_column(const CsvReader& csv);

/// The time in that column of a row, in its unit.
Time time_at(const CsvReader& csv, std::size_t column);

}  // namespace chasles
