#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// Which column of a table of poses holds which number.
struct PoseColumns {
  /// Of t, x, y, z, qx, qy, qz, qw; TUM's order.
  std::array<std::size_t, 8> index{0, 1, 2, 3, 4, 5, 6, 7};
  std::size_t count = 0;  ///< of all columns; 0: the table does not name them, or not each
  bool attitudes = true;  ///< false: a table of positions, whose quaternion has no columns
  bool angles = false;    ///< it has columns of Euler angles instead, which are not read
  std::optional<std::size_t> lost = {};  ///< the column that says whether tracking was lost
  /// Decimal digits from the unit of the times to seconds, 9 for nanoseconds; none: not stated.
  std::optional<int> time_digits = {};
  bool grouped = false;   ///< OpenVINS's groups: there are at least 8 columns
  bool of_euroc = false;  ///< named as in EuRoC's tables
};

/// The values of a row, between commas or blanks, of which there are more.
std::vector<std::string_view> split_row(std::string_view line);

/// The columns that a line names, as `# timestamp tx ty tz qx qy qz qw`, in any order and with
/// other columns beside them; none for another text. Knows TUM's names, EuRoC's, those of Aria's
/// MPS (tx_world_device, tx_odometry_device), of `rostopic echo -p` and PlotJuggler
/// (field.pose.pose.position.x, /odom/pose/pose/position/x), and OpenVINS's groups (q p v bg ba). A
/// line with the time and the position alone names a table of positions.
std::optional<PoseColumns> pose_columns(std::string_view line);

/// The unit of a present-day time stamp: 0, 3, 6 or 9 digits behind seconds.
int digits_of_stamp(std::string_view text);

/// A time in a unit of 10^-digits seconds, exact for plain decimals. Throws InputError.
Time parse_stamp(const std::string& where, std::string_view text, int digits);

}  // namespace chasles
