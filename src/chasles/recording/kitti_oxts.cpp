#include <array>
#include <chrono>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/kitti_oxts.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::year kFirstYear(1970), kLastYear(2115);  // as kLastSecond
// The number of values in a packet, and the indices of the body's acceleration and angular rate.
constexpr std::size_t kNumbers = 30, kForce = 11, kRate = 17;

int digits(const std::string& where, std::string_view text, std::size_t at, std::size_t size) {
  return static_cast<int>(parse_integer(where, text.substr(at, size)));
}

Time parse_time(const std::string& where, std::string_view text) {
  const bool shaped = text.size() >= 19 && text.size() <= 29 && text[4] == '-' && text[7] == '-' &&
                      text[10] == ' ' && text[13] == ':' && text[16] == ':' &&
                      (text.size() == 19 || text[19] == '.');
  if (!shaped) {
    throw InputError(fmt::format(
        "{}: is '{:.40}', expected a time as 2011-09-26 13:02:25.964389445", where, text));
  }
  const std::chrono::year_month_day date{
      std::chrono::year(digits(where, text, 0, 4)),
      std::chrono::month(static_cast<unsigned>(digits(where, text, 5, 2))),
      std::chrono::day(static_cast<unsigned>(digits(where, text, 8, 2)))};
  const int hour = digits(where, text, 11, 2), minute = digits(where, text, 14, 2);
  const bool read = date.year() >= kFirstYear && date.year() < kLastYear;
  if (!date.ok() || !read || hour < 0 || hour > 23 || minute < 0 || minute > 59) {
    throw InputError(fmt::format("{}: '{}' is no time of a day", where, text));
  }
  const Time day = std::chrono::sys_days(date).time_since_epoch();
  return day + std::chrono::hours(hour) + std::chrono::minutes(minute) +
         parse_seconds(where, text.substr(17));
}

OxtsPacket read_packet(const fs::path& file, Time time) {
  const std::string bytes = read_text(file);
  std::string_view rest = bytes;
  const auto words = split_words(take_line(rest));
  if (words.size() < kNumbers) {
    throw InputError(fmt::format("{}: holds {} numbers, expected {} (is the file truncated?)",
                                 file.string(), words.size(), kNumbers));
  }
  std::array<double, kNumbers> x{};
  for (std::size_t i = 0; i < kNumbers; ++i) {
    x[i] = parse_finite(fmt::format("{}: number {}", file.string(), i + 1), words[i]);
  }
  return {.sample = {.time = time,
                     .specific_force_imu = {x[kForce], x[kForce + 1], x[kForce + 2]},
                     .angular_rate_imu = {x[kRate], x[kRate + 1], x[kRate + 2]}},
          .place = {.latitude = x[0], .longitude = x[1], .altitude = x[2]},
          .roll = x[3],
          .pitch = x[4],
          .yaw = x[5]};
}

}  // namespace

std::vector<KittiStamp> read_kitti_times(const fs::path& file) {
  const std::string bytes = read_text(file);
  std::string_view rest = bytes;
  std::vector<KittiStamp> times;
  for (std::size_t index = 0; !rest.empty(); ++index) {
    const std::string_view text = trimmed(take_line(rest));
    if (text.empty()) continue;
    times.push_back(
        {.index = index, .time = parse_time(fmt::format("{}:{}", file.string(), index + 1), text)});
  }
  if (times.empty()) throw InputError(file.string() + ": holds no time, expected one a line");
  return times;
}

std::vector<OxtsPacket> read_oxts(const fs::path& folder) {
  std::vector<OxtsPacket> packets;
  for (const KittiStamp& stamp : read_kitti_times(folder / "timestamps.txt")) {
    packets.push_back(
        read_packet(folder / "data" / fmt::format("{:010}.txt", stamp.index), stamp.time));
  }
  return packets;
}

Trajectory oxts_trajectory(const std::vector<OxtsPacket>& packets) {
  Trajectory trajectory;
  if (packets.empty()) return trajectory;
  const Georeference world = oxts_georeference(packets);
  for (const OxtsPacket& p : packets) {
    const Eigen::Matrix3d R =
        so3::exp({0, 0, p.yaw}) * so3::exp({0, p.pitch, 0}) * so3::exp({p.roll, 0, 0});
    trajectory.push_back({.time = p.sample.time, .pose = {R, to_world(world, p.place)}});
  }
  return trajectory;
}

Georeference oxts_georeference(const std::vector<OxtsPacket>& packets) {
  return {.origin = packets.front().place};
}

}  // namespace chasles
