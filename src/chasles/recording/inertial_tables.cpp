#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/frame_cursor.hpp>
#include <chasles/recording/inertial_tables.hpp>

namespace chasles {
namespace {

const std::vector<std::string> kPixelColumns{"time_ns", "camera", "landmark", "u", "v"};
const std::vector<std::string> kMatchColumn{"match"};
const std::vector<std::string> kMotionColumns{"time_ns", "vx",  "vy",  "vz",  "bax",
                                              "bay",     "baz", "bgx", "bgy", "bgz"};

// Whether a pixel is a match, if the table has that column.
std::optional<bool> match_at(const CsvReader& csv) {
  if (csv.columns().size() == kPixelColumns.size()) return std::nullopt;
  const std::int64_t match = csv.integer(kPixelColumns.size());
  if (match == 0 || match == 1) return match == 1;
  throw InputError(
      fmt::format("{}: found {}, expected 0 (the track's own camera) or 1 (a match in another one)",
                  csv.where(kPixelColumns.size()), match));
}

bool states_matches(const std::vector<FeatureFrame>& frames) {
  return std::ranges::any_of(frames, [](const FeatureFrame& frame) {
    return std::ranges::any_of(frame.pixels, [](const auto& o) { return o.match.has_value(); });
  });
}

}  // namespace

const std::vector<std::string> kImuColumns{"time_ns", "wx", "wy", "wz", "ax", "ay", "az"};

Eigen::Vector3d vector_at(const CsvReader& csv, std::size_t column) {
  return {csv.finite(column), csv.finite(column + 1), csv.finite(column + 2)};
}

std::vector<ImuSample> read_imu(const std::filesystem::path& file) {
  CsvReader csv(file, kImuColumns);
  std::vector<ImuSample> imu;
  while (csv.next()) {
    const Time time = csv.time(0);
    if (!imu.empty()) check_rises(csv.where(0), imu.back().time, time);
    imu.push_back({.time = time,
                   .specific_force_imu = {csv.number(4), csv.number(5), csv.number(6)},
                   .angular_rate_imu = {csv.number(1), csv.number(2), csv.number(3)}});
  }
  return imu;
}

void write_imu(const std::vector<ImuSample>& imu, const std::filesystem::path& file) {
  fmt::memory_buffer rows;
  for (const ImuSample& row : imu) {
    const Eigen::Vector3d &w = row.angular_rate_imu, &a = row.specific_force_imu;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{}\n", row.time.count(), w.x(),
                   w.y(), w.z(), a.x(), a.y(), a.z());
  }
  write_table(file, kImuColumns, {rows.data(), rows.size()});
}

void read_pixels(const std::filesystem::path& file, std::size_t cameras,
                 std::vector<FeatureFrame>& frames) {
  CsvReader csv(file, kPixelColumns, kMatchColumn);
  FrameCursor cursor(frames);
  while (csv.next()) {
    FeatureFrame& frame = cursor.frame_of(csv);
    const std::int64_t camera = csv.integer(1);
    if (camera < 0 || std::cmp_greater_equal(camera, cameras)) {
      throw InputError(
          fmt::format("{}: there is no camera {}, expected 0 to {}: calibration.yaml "
                      "has {}",
                      csv.where(1), camera, cameras - 1, cameras));
    }
    frame.pixels.push_back({.landmark = csv.integer(2),
                            .camera = static_cast<int>(camera),
                            .match = match_at(csv),
                            .pixel = {csv.finite(3), csv.finite(4)}});
  }
}

void write_pixels(const std::vector<FeatureFrame>& frames, const std::filesystem::path& file) {
  const bool with_matches = states_matches(frames);
  fmt::memory_buffer rows;
  for (const FeatureFrame& frame : frames) {
    for (const PixelObservation& o : frame.pixels) {
      fmt::format_to(std::back_inserter(rows), "{},{},{},{},{}", frame.time.count(), o.camera,
                     o.landmark, o.pixel.x(), o.pixel.y());
      if (with_matches) fmt::format_to(std::back_inserter(rows), ",{:d}", o.is_match());
      rows.push_back('\n');
    }
  }
  std::vector<std::string> columns = kPixelColumns;
  if (with_matches) columns.insert(columns.end(), kMatchColumn.begin(), kMatchColumn.end());
  write_table(file, columns, {rows.data(), rows.size()});
}

std::vector<TrueMotion> read_true_motion(const std::filesystem::path& file,
                                         const Trajectory& truth) {
  CsvReader csv(file, kMotionColumns);
  std::vector<TrueMotion> motion;
  while (csv.next()) {
    const Time time = csv.time(0);
    if (motion.size() >= truth.size() || truth[motion.size()].time != time) {
      throw InputError(fmt::format(
          "{}: is {}, expected {}: one row for each pose of truth.tum, at its time", csv.where(0),
          time.count(),
          motion.size() < truth.size() ? fmt::to_string(truth[motion.size()].time.count())
                                       : "no further row"));
    }
    motion.push_back({.time = time,
                      .v_world = vector_at(csv, 1),
                      .accelerometer_bias = vector_at(csv, 4),
                      .gyroscope_bias = vector_at(csv, 7)});
  }
  if (motion.size() == truth.size()) return motion;
  throw InputError(
      fmt::format("{}: holds {} rows, expected {}: one for each pose of truth.tum (is "
                  "the file truncated?)",
                  file.string(), motion.size(), truth.size()));
}

void write_true_motion(const std::vector<TrueMotion>& motion, const std::filesystem::path& file) {
  fmt::memory_buffer rows;
  for (const TrueMotion& row : motion) {
    const Eigen::Vector3d &v = row.v_world, &a = row.accelerometer_bias, &g = row.gyroscope_bias;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{},{},{},{}\n", row.time.count(),
                   v.x(), v.y(), v.z(), a.x(), a.y(), a.z(), g.x(), g.y(), g.z());
  }
  write_table(file, kMotionColumns, {rows.data(), rows.size()});
}

}  // namespace chasles
