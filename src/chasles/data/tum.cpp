#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include <chasles/data/gzip.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/pose_columns.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/data/time_order.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr std::array<const char*, 8> kTumColumns{"t", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};

// OpenVINS writes six variances behind the pose; they are not read.
constexpr std::size_t kColumnsOfOpenVins = 14;

// What a row with another number of columns may be.
std::string likely_kind(std::size_t count) {
  if (count == 4) {
    return "; times and positions alone, as in EuRoC's leica0, are no poses: EuRoC's are in "
           "state_groundtruth_estimate0/data.csv";
  }
  if (count == 12 || count == 16) {
    return "; a matrix without a time, as in KITTI's pose files? Convert them with their times.txt "
           "to lines t tx ty tz qx qy qz qw";
  }
  return "";
}

bool is_tum(std::size_t count) {
  return count == kTumColumns.size() || count == kColumnsOfOpenVins;
}

// Rows of a table of poses, whose columns are those of TUM until a line names others.
class PoseRows {
 public:
  /// False for a line without names of columns.
  bool take_names(std::string_view line) {
    const auto named = pose_columns(line);
    if (named) columns_ = *named;
    return named.has_value();
  }

  /// With `unknown`, a pose that the row does not have is that, and not an error: motion capture
  /// that lost the body writes NaN, or a quaternion of zeros.
  StampedPose parse(const std::string& where, std::string_view line,
                    const std::optional<SE3>& unknown) {
    const std::vector<std::string_view> words = split_row(line);
    check_count(where, words.size());
    if (!columns_.time_digits) columns_.time_digits = digits_of_stamp(words[columns_.index[0]]);
    const Time time = parse_stamp(where + ": t", words[columns_.index[0]], *columns_.time_digits);
    Eigen::Vector<double, 7> pose;
    for (std::size_t i = 1; i < kTumColumns.size(); ++i) {
      const std::string column = where + ": " + kTumColumns[i];
      const std::string_view word = words[columns_.index[i]];
      pose[static_cast<Eigen::Index>(i) - 1] =
          unknown ? parse_number(column, word) : parse_finite(column, word);
    }
    if (unknown && (!pose.allFinite() || pose.tail<4>().isZero())) return {time, *unknown};
    return {time, {checked_quaternion(where, pose.tail<4>()), pose.head<3>()}};
  }

  const PoseColumns& columns() const { return columns_; }

 private:
  void check_count(const std::string& where, std::size_t count) {
    // A comment may name TUM's columns and say more.
    if (columns_.index == PoseColumns{}.index && is_tum(count)) columns_.count = 0;
    if (columns_.count > 0 ? count == columns_.count : is_tum(count)) return;
    throw InputError(fmt::format("{}: has {} columns, expected {}{}", where, count,
                                 columns_.count > 0
                                     ? fmt::format("{}, as many as have names", columns_.count)
                                     : "8: t tx ty tz qx qy qz qw",
                                 likely_kind(count)));
  }

  PoseColumns columns_;
};

bool begins_with_letter(std::string_view line) {
  const auto c = static_cast<unsigned char>(line.front());
  return std::isalpha(c) != 0 && !line.starts_with("nan") && !line.starts_with("inf");
}

// EuRoC's vicon0 and mocap0 have the pose of a sensor; sensor.yaml beside the table, if there is
// one, says where it is on the body, which is the IMU.
void move_to_body(const std::filesystem::path& table, Trajectory& trajectory) {
  const std::filesystem::path file = table.parent_path() / "sensor.yaml";
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  const YamlMap sensor = YamlMap::read(file, {});
  if (!sensor.has("T_BS")) return;
  const SE3 body_T_sensor = sensor.motion("T_BS");
  if (body_T_sensor.R.isIdentity(0) && body_T_sensor.p.isZero(0)) return;
  for (StampedPose& row : trajectory) row.pose = row.pose * body_T_sensor.inverse();
}

// `use` takes the place and the pose of each row.
PoseColumns read_rows(const std::filesystem::path& file, const std::optional<SE3>& unknown,
                      const std::function<void(const std::string&, const StampedPose&)>& use) {
  std::string bytes = read_plain_or_gzip(file);
  remove_byte_order_mark(bytes);
  PoseRows rows;
  std::string_view rest = bytes;
  bool first = true;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = trimmed(take_line(rest));
    if (line.empty()) continue;
    if (line.front() == '#') {
      if (first) rows.take_names(line);
      continue;
    }
    if (first && begins_with_letter(line) && rows.take_names(line)) continue;
    const std::string where = fmt::format("{}:{}", file.string(), number);
    use(where, rows.parse(where, line, unknown));
    first = false;
  }
  if (!first) return rows.columns();
  throw InputError(
      fmt::format("{}: holds no pose, expected lines `t tx ty tz qx qy qz qw`", file.string()));
}

}  // namespace

Trajectory read_tum(const std::filesystem::path& file) {
  Trajectory trajectory;
  const auto add = [&](const std::string& where, const StampedPose& row) {
    if (!trajectory.empty()) check_rises(where, trajectory.back().time, row.time);
    trajectory.push_back(row);
  };
  const PoseColumns columns = read_rows(file, std::nullopt, add);
  if (columns.of_euroc) move_to_body(file, trajectory);
  return trajectory;
}

Trajectory read_tum(const std::filesystem::path& file, std::vector<std::string>& remarks) {
  const std::string what = "poses of " + file.filename().string();
  const SE3 unknown{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Constant(std::nan(""))};
  Trajectory trajectory;
  const PoseColumns columns =
      read_rows(file, unknown, [&](const auto&, const auto& row) { trajectory.push_back(row); });
  const auto known = [](const StampedPose& row) { return row.pose.p.allFinite(); };
  leave_out_unknown(file, known, what, trajectory, remarks);
  bring_into_order(trajectory, what, remarks);
  if (columns.of_euroc) move_to_body(file, trajectory);
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
