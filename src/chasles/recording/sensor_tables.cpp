#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/imu_columns.hpp>
#include <chasles/recording/sensor_tables.hpp>
#include <chasles/recording/split_imu.hpp>
#include <chasles/recording/table_times.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The better ones first. Sensor Logger's Accelerometer has no gravity.
constexpr std::array<std::string_view, 10> kForceTables{"totalacceleration",
                                                        "total_acceleration",
                                                        "accelerometeruncalibrated",
                                                        "accel",
                                                        "acc",
                                                        "acceleration",
                                                        "accelerometer",
                                                        "linear_acceleration",
                                                        "accelerations",
                                                        "accelerometer_data"};
constexpr std::array<std::string_view, 8> kRateTables{"gyro",
                                                      "gyr",
                                                      "gyroscope",
                                                      "angular_velocity",
                                                      "angularvelocity",
                                                      "gyros",
                                                      "gyroscope_data",
                                                      "gyroscopeuncalibrated"};
// The median of what an accelerometer with gravity measures is never below [m/s^2].
constexpr double kLeastMedian = 5;

/// A table and its place in the list of names.
struct RankedTable {
  std::size_t rank;
  fs::path file;
};

// gyro0/data.csv of EuRoC's layout has its name from the folder.
bool is_data_of_folder(const fs::path& file) {
  const std::string name = file.filename().string();
  return name == "data.csv" || name == "data.csv.gz";
}

std::string shown_name(const fs::path& file) {
  const std::string name = file.filename().string();
  return is_data_of_folder(file) ? file.parent_path().filename().string() + "/" + name : name;
}

// The name without ending and without a 0 behind it, in small letters.
std::string plain_name(const fs::path& file) {
  std::string name = is_data_of_folder(file) ? file.parent_path().filename().string() + ".csv"
                                             : file.filename().string();
  name = lower_case(name);
  if (name.ends_with(".gz")) name.resize(name.size() - 3);
  if (!name.ends_with(".csv") && !name.ends_with(".txt") && !name.ends_with(".tsv")) return {};
  name.resize(name.size() - 4);
  if (name.ends_with('0')) name.pop_back();
  return name;
}

template <typename Names>
std::optional<fs::path> best_table(const std::vector<fs::path>& files, const Names& names,
                                   std::vector<std::string>& remarks) {
  std::vector<RankedTable> found;
  for (const fs::path& file : files) {
    const auto name = std::ranges::find(names, plain_name(file));
    if (name != names.end()) {
      found.push_back({.rank = static_cast<std::size_t>(name - names.begin()), .file = file});
    }
  }
  if (found.empty()) return std::nullopt;
  std::ranges::stable_sort(found, {}, &RankedTable::rank);
  for (std::size_t i = 1; i < found.size(); ++i) {
    remarks.push_back(fmt::format("{} is read, and {} is not", shown_name(found[0].file),
                                  shown_name(found[i].file)));
  }
  return found[0].file;
}

SensorStream read_table(const fs::path& file, bool accelerometer,
                        std::vector<std::string>& remarks) {
  CsvReader csv(file.string(), read_plain_or_gzip(file));
  const auto time = time_column(csv);
  if (!time) fail_sensor_columns(csv, "none is a time");
  TableTimes written{.column = *time};
  const VectorColumns axes =
      find_sensor_axes(csv, accelerometer ? ImuQuantity::kForce : ImuQuantity::kRate);
  SensorStream stream{.name = shown_name(file), .samples = {}};
  while (csv.next()) {
    stream.samples.push_back({.time = {}, .value = vector_of(csv, axes)});
    add_time(csv, written);
  }
  const std::vector<Time> times =
      read_table_times(csv, file.string(), stream.name, written, remarks);
  for (std::size_t i = 0; i < times.size(); ++i) stream.samples[i].time = times[i];
  remark_on_open_end(file, remarks);
  if (axes.factor != 1) {
    remarks.push_back(fmt::format("{} is in {}: converted to {}", stream.name, axes.unit,
                                  accelerometer ? "m/s^2" : "rad/s"));
  }
  return stream;
}

void check_gravity(const fs::path& file, const SensorStream& forces) {
  std::vector<double> sizes;
  for (const AxesSample& s : forces.samples) {
    if (s.value.allFinite()) sizes.push_back(s.value.norm());
  }
  if (sizes.empty()) return;
  const double size = median(std::move(sizes));
  if (size >= kLeastMedian) return;
  throw InputError(fmt::format(
      "{}: the median of the accelerations is {:.2f} m/s^2, expected about 9.8, with gravity: {}",
      file.string(), size,
      std::abs(size - 1) < 0.2
          ? "are they in g? Write the unit behind the names: x (g), y (g), z (g)"
          : "this table has accelerations without gravity, as apps compute them; record the total "
            "acceleration (TotalAcceleration.csv, or the uncalibrated accelerometer) as well"));
}

}  // namespace

SensorTables find_sensor_tables(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored)) {
      files.push_back(entry.path());
    } else if (entry.is_directory(ignored)) {
      for (const char* name : {"data.csv", "data.csv.gz"}) {
        if (fs::exists(entry.path() / name, ignored)) files.push_back(entry.path() / name);
      }
    }
  }
  std::sort(files.begin(), files.end());
  SensorTables tables;
  tables.accelerometer = best_table(files, kForceTables, tables.remarks);
  tables.gyroscope = best_table(files, kRateTables, tables.remarks);
  return tables;
}

bool has_sensor_tables(const fs::path& folder) {
  const SensorTables tables = find_sensor_tables(folder);
  return tables.accelerometer || tables.gyroscope;
}

void read_sensor_tables(const SensorTables& tables, const fs::path& folder, Recording& recording) {
  if (!tables.accelerometer || !tables.gyroscope) {
    const bool forces = tables.accelerometer.has_value();
    throw InputError(fmt::format(
        "{}: has {}, but no table of the {} and no imu.csv, expected both sensors of an IMU: {}",
        folder.string(), shown_name(forces ? *tables.accelerometer : *tables.gyroscope),
        forces ? "gyroscope" : "accelerometer",
        forces ? "gyro.csv or Gyroscope.csv, with time,x,y,z in rad/s"
               : "accel.csv or TotalAcceleration.csv, with time,x,y,z in m/s^2, with gravity"));
  }
  recording.remarks.insert(recording.remarks.end(), tables.remarks.begin(), tables.remarks.end());
  SensorStream forces = read_table(*tables.accelerometer, true, recording.remarks);
  SensorStream rates = read_table(*tables.gyroscope, false, recording.remarks);
  check_gravity(*tables.accelerometer, forces);
  join_streams(folder.string(), std::move(forces), std::move(rates), Eigen::Matrix3d::Identity(),
               recording);
}

}  // namespace chasles
