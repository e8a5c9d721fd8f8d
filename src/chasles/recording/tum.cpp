#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/pose_columns.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

constexpr std::array<const char*, 8> kTumColumns{"t", "tx", "ty", "tz", "qx", "qy", "qz", "qw"};

// OpenVINS writes six variances behind the pose, others the upper or the lower triangle of a
// covariance, or all of it; they are not read, so their order does not matter.
constexpr std::array<std::size_t, 4> kTumCounts{8, 8 + 6, 8 + 21, 8 + 36};

// What a row with another number of columns may be.
std::string likely_kind(std::size_t count) {
  if (count == 4) {
    return "; times and positions alone, as in EuRoC's leica0, are no poses: EuRoC's are in "
           "state_groundtruth_estimate0/data.csv";
  }
  if (count == 7) {
    return "; Euler angles behind the position? Convert them to quaternions";
  }
  if (count == 12 || count == 16) {
    return "; a matrix without a time, as in KITTI's pose files? Convert them with their times.txt "
           "to lines t tx ty tz qx qy qz qw";
  }
  return "";
}

bool is_tum(std::size_t count) { return std::ranges::find(kTumCounts, count) != kTumCounts.end(); }

// What a row says about its pose.
enum class RowKind {
  kPose,
  kNotFinite,  // NaN, as motion capture writes it
  kZero,       // a quaternion of zeros: lost, or no attitude at all
  kLost,       // as its column is_lost says
};

struct PoseRow {
  Time time{};
  SE3 pose = {};  // without a quaternion the identity
  RowKind kind = RowKind::kPose;
};

// Which tables are taken.
struct TableRules {
  bool mend = false;       // rows without a pose are no errors
  bool positions = false;  // so are tables without attitudes
};

// Rows of a table of poses, whose columns are those of TUM until a line names others.
class PoseRows {
 public:
  explicit PoseRows(const TableRules& rules) : rules_(rules) {}

  /// False for a line without names of columns.
  bool take_names(std::string_view line) {
    const auto named = pose_columns(line);
    const bool taken = named && (named->attitudes || rules_.positions);
    if (taken) columns_ = *named;
    return taken;
  }

  PoseRow parse(const std::string& where, std::string_view line) {
    const std::vector<std::string_view> words = split_row(line);
    check_count(where, words.size());
    if (!columns_.time_digits) columns_.time_digits = digits_of_stamp(words[columns_.index[0]]);
    PoseRow row{.time =
                    parse_stamp(where + ": t", words[columns_.index[0]], *columns_.time_digits)};
    if (rules_.mend && columns_.lost && is_true(words[*columns_.lost])) {
      row.kind = RowKind::kLost;
      return row;
    }
    Eigen::Vector<double, 7> pose;
    pose << 0, 0, 0, 0, 0, 0, 1;
    for (std::size_t i = 1; i < (columns_.attitudes ? kTumColumns.size() : 4); ++i) {
      const std::string column = where + ": " + kTumColumns[i];
      const std::string_view word = words[columns_.index[i]];
      pose[static_cast<Eigen::Index>(i) - 1] =
          rules_.mend ? parse_number(column, word) : parse_finite(column, word);
    }
    take_pose(where, pose, row);
    return row;
  }

  const PoseColumns& columns() const { return columns_; }

 private:
  static bool is_true(std::string_view word) {
    return word == "1" || word == "true" || word == "True" || word == "TRUE";
  }

  void take_pose(const std::string& where, const Eigen::Vector<double, 7>& pose,
                 PoseRow& row) const {
    row.pose.p = pose.head<3>();
    if (rules_.mend && !pose.allFinite()) {
      row.kind = RowKind::kNotFinite;
    } else if (rules_.mend && pose.tail<4>().isZero()) {
      row.kind = RowKind::kZero;
    } else {
      check_order_of(where, pose);
      row.pose.R = checked_quaternion(where, pose.tail<4>());
    }
  }

  // A quaternion before the position.
  static void check_order_of(const std::string& where, const Eigen::Vector<double, 7>& pose) {
    constexpr double kUnit = 1e-3;
    const auto is_unit = [&](Eigen::Index from) {
      return std::abs(pose.segment<4>(from).norm() - 1) < kUnit;
    };
    if (is_unit(3) || !is_unit(0)) return;
    throw InputError(fmt::format(
        "{}: the last four numbers are no unit quaternion, and the first four behind the time are "
        "one: the quaternion comes before the position; name the columns in the first line, as "
        "`# t qx qy qz qw tx ty tz`",
        where));
  }

  void check_count(const std::string& where, std::size_t count) {
    if (columns_.grouped && count >= kTumColumns.size()) return;
    // A comment may name TUM's columns and say more.
    if (columns_.index == PoseColumns{}.index && is_tum(count)) columns_.count = 0;
    const bool unnamed = columns_.count == 0 && !columns_.grouped;
    if (unnamed && rules_.positions && count == 4) columns_.attitudes = false;
    if (unnamed ? is_tum(count) || !columns_.attitudes : count == columns_.count) return;
    throw InputError(fmt::format("{}: has {} columns, expected {}{}", where, count,
                                 columns_.count > 0
                                     ? fmt::format("{}, as many as have names", columns_.count)
                                     : "8: t tx ty tz qx qy qz qw",
                                 likely_kind(count)));
  }

  TableRules rules_;
  PoseColumns columns_;
};

bool begins_names(std::string_view line) {
  const auto c = static_cast<unsigned char>(line.front());
  const bool letter = std::isalpha(c) != 0 && !line.starts_with("nan") && !line.starts_with("inf");
  return letter || c == '%' || c == '/' || c == '_';
}

// The line of a spreadsheet without quotes, its semicolons as commas, and its decimal commas as
// points. Others stay as they are.
std::string_view plain_line(std::string_view line, std::string& storage) {
  if (line.find_first_of(";\"") == std::string_view::npos) return line;
  storage = line;
  std::erase(storage, '"');
  const bool semicolons = storage.find(';') != std::string::npos;
  if (semicolons && storage.find('.') == std::string::npos) {
    std::ranges::replace(storage, ',', '.');
  }
  std::ranges::replace(storage, ';', ',');
  return storage;
}

// body_T_sensor by sensor.yaml beside one of EuRoC's tables, if it is there: where the marker or
// the prism is on the body, which is the IMU.
std::optional<SE3> sensor_on_body(const std::filesystem::path& table) {
  const std::filesystem::path file = table.parent_path() / "sensor.yaml";
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return std::nullopt;
  const YamlMap sensor = YamlMap::read(file, {});
  if (!sensor.has("T_BS")) return std::nullopt;
  return sensor.motion("T_BS");
}

void move_to_body(const std::filesystem::path& table, Trajectory& trajectory) {
  const auto body_T_sensor = sensor_on_body(table);
  if (!body_T_sensor) return;
  if (body_T_sensor->R.isIdentity(0) && body_T_sensor->p.isZero(0)) return;
  for (StampedPose& row : trajectory) row.pose = row.pose * body_T_sensor->inverse();
}

// `use` takes the place and the pose of each row.
PoseColumns read_rows(const std::filesystem::path& file, const TableRules& rules,
                      const std::function<void(const std::string&, const PoseRow&)>& use) {
  std::string bytes = read_plain_or_gzip(file), storage;
  remove_byte_order_mark(bytes);
  PoseRows rows(rules);
  std::string_view rest = bytes;
  bool first = true;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = plain_line(trimmed(take_line(rest)), storage);
    if (line.empty()) continue;
    if (line.front() == '#') {
      if (first) rows.take_names(line);
      continue;
    }
    if (first && begins_names(line) && rows.take_names(line)) continue;
    const std::string where = fmt::format("{}:{}", file.string(), number);
    use(where, rows.parse(where, line));
    first = false;
  }
  if (!first) return rows.columns();
  throw InputError(
      fmt::format("{}: holds no pose, expected lines `t tx ty tz qx qy qz qw`", file.string()));
}

// Leaves out the rows of that kind, with a remark.
void leave_out(RowKind kind, std::size_t all, const std::string& what, const char* why,
               std::vector<PoseRow>& rows, std::vector<std::string>& remarks) {
  const std::size_t count = std::erase_if(rows, [&](const PoseRow& r) { return r.kind == kind; });
  if (count == 0) return;
  remarks.push_back(fmt::format("{} of {} {} {}: left out", count, all, what, why));
}

// Leaves out the rows that are no poses, with remarks. Throws InputError if none is left.
void leave_out_lost(const std::filesystem::path& file, const std::string& what,
                    std::vector<PoseRow>& rows, std::vector<std::string>& remarks) {
  const std::size_t all = rows.size();
  std::vector<std::string> left_out;
  leave_out(RowKind::kNotFinite, all, what, "are not finite numbers", rows, left_out);
  leave_out(RowKind::kZero, all, what, "are lost (their quaternion is zero)", rows, left_out);
  leave_out(RowKind::kLost, all, what, "are lost (is_lost)", rows, left_out);
  if (rows.empty()) {
    throw InputError(fmt::format("{}: none of the {} {} is a pose of finite numbers: {}",
                                 file.string(), all, what, fmt::join(left_out, "; ")));
  }
  remarks.insert(remarks.end(), left_out.begin(), left_out.end());
}

// A table of positions whose quaternions were left at zero.
bool take_zeros_as_positions(std::vector<PoseRow>& rows) {
  const auto is = [&](RowKind kind) {
    return std::ranges::any_of(rows, [&](const PoseRow& r) { return r.kind == kind; });
  };
  if (is(RowKind::kPose) || !is(RowKind::kZero)) return false;
  for (PoseRow& row : rows) {
    if (row.kind == RowKind::kZero) row.kind = RowKind::kPose;
  }
  return true;
}

TruthTable read_table(const std::filesystem::path& file, const TableRules& rules,
                      std::vector<std::string>& remarks) {
  const std::string what = "poses of " + file.filename().string();
  std::vector<PoseRow> rows;
  const PoseColumns columns =
      read_rows(file, rules, [&](const auto&, const PoseRow& row) { rows.push_back(row); });
  TruthTable table{.poses = {}, .attitudes = columns.attitudes};
  if (rules.positions && take_zeros_as_positions(rows)) table.attitudes = false;
  leave_out_lost(file, what, rows, remarks);
  for (const PoseRow& row : rows) table.poses.push_back({.time = row.time, .pose = row.pose});
  bring_into_order(table.poses, what, remarks);
  if (columns.angles && !columns.attitudes) {
    remarks.push_back(fmt::format(
        "{} has Euler angles, whose order and unit it does not state: only its positions are read; "
        "write quaternions (qx qy qz qw) to compare attitudes",
        file.filename().string()));
  }
  if (!columns.of_euroc) return table;
  if (table.attitudes) {
    move_to_body(file, table.poses);
  } else if (const auto body_T_sensor = sensor_on_body(file)) {
    table.point_imu = body_T_sensor->p;
  }
  return table;
}

}  // namespace

Trajectory read_tum(const std::filesystem::path& file) {
  Trajectory trajectory;
  const auto add = [&](const std::string& where, const PoseRow& row) {
    if (!trajectory.empty()) check_rises(where, trajectory.back().time, row.time);
    trajectory.push_back({.time = row.time, .pose = row.pose});
  };
  const PoseColumns columns = read_rows(file, {}, add);
  if (columns.of_euroc) move_to_body(file, trajectory);
  return trajectory;
}

Trajectory read_tum(const std::filesystem::path& file, std::vector<std::string>& remarks) {
  return read_table(file, {.mend = true}, remarks).poses;
}

TruthTable read_truth_table(const std::filesystem::path& file, std::vector<std::string>& remarks) {
  return read_table(file, {.mend = true, .positions = true}, remarks);
}

void read_truth_of_recording(const std::filesystem::path& file, Recording& recording) {
  TruthTable table = read_truth_table(file, recording.remarks);
  recording.truth = std::move(table.poses);
  recording.truth_attitudes = table.attitudes;
  recording.truth_point_imu = table.point_imu;
}

void write_tum(const Trajectory& trajectory, const std::filesystem::path& file) {
  constexpr std::size_t kRowsOfPart = 4096;
  std::size_t row = 0;
  bool begins = true;
  write_parts(file, [&](std::string& text) {
    if (!begins && row == trajectory.size()) return false;
    if (std::exchange(begins, false)) text = "# t tx ty tz qx qy qz qw\n";
    for (const std::size_t end = std::min(trajectory.size(), row + kRowsOfPart); row < end; ++row) {
      const SE3& pose = trajectory[row].pose;
      const Eigen::Vector4d q = unit_quaternion(pose.R);
      const Eigen::Vector3d& p = pose.p;
      fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}\n",
                     seconds_text(trajectory[row].time), p.x(), p.y(), p.z(), q[0], q[1], q[2],
                     q[3]);
    }
    return true;
  });
}

}  // namespace chasles
