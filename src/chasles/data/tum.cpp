#include <array>

#include <fmt/format.h>

#include <chasles/data/gzip.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr std::array<const char*, 8> kTumColumns{"t", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};

// OpenVINS writes six variances behind the pose; they are not read.
constexpr std::size_t kColumnsOfOpenVins = 14;

StampedPose parse_row(const std::string& where, const std::vector<std::string_view>& words) {
  if (words.size() != kTumColumns.size() && words.size() != kColumnsOfOpenVins) {
    throw InputError(fmt::format("{}: has {} columns, expected {}: t tx ty tz qx qy qz qw", where,
                                 words.size(), kTumColumns.size()));
  }
  std::array<double, 8> numbers{};
  for (std::size_t i = 1; i < kTumColumns.size(); ++i) {
    numbers[i] = parse_finite(where + ": " + kTumColumns[i], words[i]);
  }
  return {.time = parse_seconds(where + ": t", words[0]),
          .pose = {checked_quaternion(where, {numbers[4], numbers[5], numbers[6], numbers[7]}),
                   {numbers[1], numbers[2], numbers[3]}}};
}

}  // namespace

Trajectory read_tum(const std::filesystem::path& file) {
  const std::string bytes = read_plain_or_gzip(file);
  Trajectory trajectory;
  std::string_view rest = bytes;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = trimmed(take_line(rest));
    if (line.empty() || line.front() == '#') continue;
    const std::string where = fmt::format("{}:{}", file.string(), number);
    const StampedPose row = parse_row(where, split_words(line));
    if (!trajectory.empty()) check_rises(where, trajectory.back().time, row.time);
    trajectory.push_back(row);
  }
  if (trajectory.empty()) {
    throw InputError(
        fmt::format("{}: holds no pose, expected lines `t tx ty tz qx qy qz qw`", file.string()));
  }
  return trajectory;
}

void write_tum(const Trajectory& trajectory, const std::filesystem::path& file) {
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "# t tx ty tz qx qy qz qw\n");
  for (const StampedPose& row : trajectory) {
    const Eigen::Vector4d q = unit_quaternion(row.pose.R);
    const Eigen::Vector3d& p = row.pose.p;
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}\n", seconds_text(row.time),
                   p.x(), p.y(), p.z(), q[0], q[1], q[2], q[3]);
  }
  write_file(file, {text.data(), text.size()});
}

}  // namespace chasles
