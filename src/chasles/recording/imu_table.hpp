#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/codec/csv.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The samples of an IMU table as people and programs write it, plain or gzip-compressed, in the
/// order of its rows. The names of the columns determine their meaning, in any order: this
/// program's (time_ns,wx,…,az), EuRoC's (timestamp,w_RS_S_x,…), those of kalibr_bagextractor,
/// `rostopic echo -p`, bagpy, PlotJuggler and phone apps (imu_columns.hpp). The rows of
/// `ros2 topic echo --csv` need no names. Further columns are ignored. Separators, quotes and
/// decimal commas are found (csv_dialect.hpp). Numbers may be "nan" or "inf": tidy_samples()
/// removes such samples.
///
/// Rates in deg/s and forces in g become SI by the units behind the names. Times are nanoseconds,
/// in the unit behind the name, or in seconds where they have decimals (time_text.hpp). `remarks`:
/// a sentence on each of these.
///
/// Throws InputError with file, line and column: for names that are not known or are there twice,
/// units of other quantities, times whose digits do not distinguish the rows, and for samples whose
/// gravity was removed.
std::vector<ImuSample> read_imu_table(const std::filesystem::path& file,
                                      std::vector<std::string>& remarks);
std::vector<ImuSample> read_imu_table(const std::filesystem::path& file);

/// The same until the last whole row, of a table that another program is still writing.
std::vector<ImuSample> read_whole_rows(const std::filesystem::path& file);

/// Whether a text begins as the rows of `ros2 topic echo --csv` of a sensor_msgs/Imu.
bool is_ros2_echo(std::string_view bytes);

/// Whether a file begins as such a table: its names have a time, rates and forces.
bool is_imu_table(const std::filesystem::path& file);

/// The IMU table of a recording's folder: imu.csv or imu0.csv, also with .gz; without them the only
/// other table (.csv, .txt, .tsv, also with .gz) that is one, with a remark. Nothing without one.
/// Throws InputError if there are several, and for imu.csv that another program has compressed.
std::optional<std::filesystem::path> find_imu_table(const std::filesystem::path& folder,
                                                    std::vector<std::string>& remarks);

}  // namespace chasles
