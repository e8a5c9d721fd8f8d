#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/pose_columns.hpp>

namespace chasles {
namespace {

constexpr std::size_t kTime = 0;
constexpr std::size_t kPoseValues = 8;

/// The names of a column in TUM's files, EuRoC's, and those of scripts.
constexpr std::array<std::array<std::string_view, 8>, kPoseValues> kNames{{
    {"timestamp", "time", "t", "ts", "stamp", "sec", "tracking_timestamp", "__time"},
    {"tx", "px", "p_x", "x", "p_rs_r_x", "pos_x", "position_x", "translation_x"},
    {"ty", "py", "p_y", "y", "p_rs_r_y", "pos_y", "position_y", "translation_y"},
    {"tz", "pz", "p_z", "z", "p_rs_r_z", "pos_z", "position_z", "translation_z"},
    {"qx", "q_x", "q_rs_x", "rot_x", "quat_x", "ox", "orientation_x", "rotation_x"},
    {"qy", "q_y", "q_rs_y", "rot_y", "quat_y", "oy", "orientation_y", "rotation_y"},
    {"qz", "q_z", "q_rs_z", "rot_z", "quat_z", "oz", "orientation_z", "rotation_z"},
    {"qw", "q_w", "q_rs_w", "rot_w", "quat_w", "ow", "orientation_w", "rotation_w"},
}};
constexpr std::array<std::string_view, 3> kAngles{"roll", "pitch", "yaw"};
constexpr std::string_view kTimeOfEcho = "%time";  // of rostopic: when the message was recorded

struct Name {
  std::string name, unit;  // "timestamp [ns]", "timestamp(ns)" and "timestamp_ns" have a unit
  bool path = false;       // "field.header.stamp"
};

bool ends_with(std::string_view text, std::string_view end, std::string& name) {
  if (!text.ends_with(end)) return false;
  name = end;
  return true;
}

// The field of a message by its path, "field.pose.pose.position.x" or "/odom/pose/position/x", and
// the columns of Aria's tables without the frames in their names.
std::string short_name(std::string name) {
  for (const std::string_view frames : {"_world_device", "_odometry_device"}) {
    if (name.ends_with(frames)) name.resize(name.size() - frames.size());
  }
  std::ranges::replace(name, '/', '.');
  if (name.find('.') == std::string::npos) return name;
  std::string found = name;
  for (const std::string_view field : {"position", "translation", "orientation", "rotation"}) {
    for (const char axis : {'x', 'y', 'z', 'w'}) {
      if (!ends_with(name, fmt::format("{}.{}", field, axis), found)) continue;
      std::ranges::replace(found, '.', '_');
      return found;
    }
  }
  return name.ends_with("header.stamp") ? "stamp" : found;
}

// The names of a line, in lower case.
std::vector<Name> names_of(std::string_view line) {
  std::vector<Name> names(1);
  const bool commas = line.find(',') != std::string_view::npos;
  bool unit = false, blank = false;
  for (const char c : lower_case(line)) {
    const bool is_blank = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (c == '[' || c == '(') {
      unit = true;
    } else if (c == ']' || c == ')') {
      unit = false;
    } else if (unit) {
      names.back().unit += c;
    } else if (c == ',' || (!commas && blank && !is_blank && !names.back().name.empty())) {
      names.emplace_back();
    }
    const bool part = !unit && !is_blank && std::string_view("[](),#").find(c) == std::string::npos;
    if (part) names.back().name += c;
    blank = is_blank;
  }
  // "# format: timestamp tx …"
  if (names.size() > 1 && names.front().name.ends_with(':')) names.erase(names.begin());
  for (Name& each : names) {
    each.path = each.name.ends_with(".header.stamp");
    each.name = short_name(std::move(each.name));
    for (const std::string_view end : {"_ns", "_us", "_ms", "_s"}) {
      if (!each.name.ends_with(end) || each.name.size() == end.size()) continue;
      each.unit = end.substr(1);
      each.name.resize(each.name.size() - end.size());
      break;
    }
  }
  return names;
}

std::optional<int> digits_of_unit(std::string_view unit) {
  if (unit == "ns" || unit == "nsec") return 9;
  if (unit == "us" || unit == "usec") return 6;
  if (unit == "ms" || unit == "msec") return 3;
  if (unit == "s" || unit == "sec") return 0;
  return std::nullopt;
}

// "timestamp q p v bg ba …" of OpenVINS, with or without the numbers of values: the quaternion of
// JPL's convention from the world to the IMU has the numbers of Hamilton's from the IMU to it.
std::optional<PoseColumns> groups_of(const std::vector<Name>& names) {
  if (names.size() < 3 || names[0].name != "timestamp" || names[1].name != "q" ||
      names[2].name != "p") {
    return std::nullopt;
  }
  PoseColumns columns{.index = {0, 5, 6, 7, 1, 2, 3, 4}};
  columns.grouped = true;
  return columns;
}

// What the names say besides the eight numbers of a pose.
bool complete(const std::vector<Name>& names, std::array<bool, kPoseValues>& found,
              PoseColumns& columns) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i].name;
    if (name == "is_lost") columns.lost = i;
    if (name == kTimeOfEcho && !found[kTime]) {
      found[kTime] = true;
      columns.index[kTime] = i;
      columns.time_digits = 9;
    }
    if (std::ranges::find(kAngles, name) != kAngles.end()) columns.angles = true;
  }
  const auto known = std::ranges::count(found, true);
  columns.attitudes = known == kPoseValues;
  const bool positions = std::all_of(found.begin(), found.begin() + 4, [](bool f) { return f; });
  return columns.attitudes || (positions && known == 4);
}

}  // namespace

std::vector<std::string_view> split_row(std::string_view line) {
  std::vector<std::string_view> values;
  for (std::string_view rest = line; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    values.push_back(trimmed(rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  std::vector<std::string_view> words = split_words(line);
  return words.size() > values.size() ? words : values;
}

std::optional<PoseColumns> pose_columns(std::string_view line) {
  const std::vector<Name> names = names_of(line);
  if (const auto groups = groups_of(names)) return groups;
  PoseColumns columns;
  columns.count = names.size();
  std::array<bool, kPoseValues> found{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t value = 0; value < kPoseValues; ++value) {
      if (found[value] || std::ranges::find(kNames[value], names[i].name) == kNames[value].end()) {
        continue;
      }
      found[value] = true;
      columns.index[value] = i;
      columns.of_euroc = columns.of_euroc || names[i].name == "p_rs_r_x";
      if (value != kTime) continue;
      columns.time_digits = digits_of_unit(names[i].unit);
      if (names[i].path) columns.time_digits = 9;  // rostopic writes stamps in nanoseconds
    }
  }
  if (!complete(names, found, columns)) return std::nullopt;
  if (columns.of_euroc && !columns.time_digits) columns.time_digits = 9;
  return columns;
}

int digits_of_stamp(std::string_view text) {
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return 0;
  for (const int digits : {3, 6, 9}) {
    const double seconds = std::abs(value) / std::pow(10, digits);
    if (seconds >= 1e8 && seconds < static_cast<double>(kLastSecond)) return digits;
  }
  return 0;
}

Time parse_stamp(const std::string& where, std::string_view text, int digits) {
  if (digits == 0) return parse_seconds(where, text);
  const bool negative = text.starts_with('-');
  const std::string_view size = text.substr(negative ? 1 : 0);
  const std::size_t point = std::min(size.find('.'), size.size());
  const std::string whole(size.substr(0, point));
  const std::string rest(size.substr(std::min(point + 1, size.size())));
  if (whole.empty() || (whole + rest).find_first_not_of("0123456789") != std::string::npos) {
    const double seconds = parse_finite(where, text) / std::pow(10, digits);
    return parse_seconds(where, fmt::format("{:.9f}", seconds));
  }
  // The decimal point moves to the left.
  const auto moved = static_cast<std::size_t>(digits);
  const std::string padded = std::string(moved, '0') + whole;
  const std::size_t split = padded.size() - moved;
  return parse_seconds(where, fmt::format("{}{}.{}{}", negative ? "-" : "", padded.substr(0, split),
                                          padded.substr(split), rest));
}

}  // namespace chasles
