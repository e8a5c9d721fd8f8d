#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/time.hpp>

namespace chasles {

/// What remarks call the rows of a truth.
inline constexpr const char* kTruePoses = "poses of the truth";

/// Counts of rows that were not in order.
struct OrderCounts {
  std::size_t late = 0;      ///< rows with an earlier time than a row above them
  std::size_t repeated = 0;  ///< rows with the time of another row: left out
};

/// Sorts rows by their `time`. Of rows with the same time the first stays. Times then rise
/// strictly, as Recording requires.
template <typename Row>
OrderCounts bring_into_order(std::vector<Row>& rows) {
  OrderCounts counts;
  for (std::size_t i = 1, latest = 0; i < rows.size(); ++i) {
    if (rows[i].time < rows[latest].time) {
      ++counts.late;
    } else {
      latest = i;
    }
  }
  const auto earlier = [](const Row& a, const Row& b) { return a.time < b.time; };
  const auto same = [](const Row& a, const Row& b) { return a.time == b.time; };
  if (counts.late > 0) std::stable_sort(rows.begin(), rows.end(), earlier);
  const auto end = std::unique(rows.begin(), rows.end(), same);
  counts.repeated = static_cast<std::size_t>(rows.end() - end);
  rows.erase(end, rows.end());
  return counts;
}

/// Neighbouring rows that all have earlier times than a row above them: first to before `end`.
struct LateRows {
  std::size_t first = 0, end = 0;
};

template <typename Row>
LateRows longest_late_rows(const std::vector<Row>& rows) {
  LateRows longest, late;
  for (std::size_t i = 1, latest = 0; i < rows.size(); ++i) {
    const bool is_late = rows[i].time < rows[latest].time;
    if (!is_late) latest = i;
    if (late.end != i) late.first = i;
    if (is_late) late.end = i + 1;
    if (is_late && late.end - late.first > longest.end - longest.first) longest = late;
  }
  return longest;
}

/// Whether rows with the same time are the same measurement, written twice.
template <typename Row>
bool is_copy(const Row& a, const Row& b) {
  if constexpr (requires { a.specific_force_imu; }) {
    return a.specific_force_imu == b.specific_force_imu && a.angular_rate_imu == b.angular_rate_imu;
  }
  return true;
}

/// Throws InputError if a clock was set back while it was read: rows of half a second or more have
/// times between those of rows above. Sorted, two stretches of the recording would be mixed. Copies
/// of rows above, and whole stretches in another order, are no such case.
template <typename Row>
void require_one_clock(const std::vector<Row>& rows, const std::string& what) {
  constexpr double kShortest = 0.5;  // [s]
  const LateRows late = longest_late_rows(rows);
  if (late.first == 0) return;
  const Time begin = rows[late.first].time, end = rows[late.end - 1].time;
  if (to_seconds(end - begin) < kShortest) return;
  const auto earlier = [](const Row* a, const Row* b) { return a->time < b->time; };
  std::vector<const Row*> above;
  for (std::size_t i = 0; i < late.first; ++i) above.push_back(&rows[i]);
  std::sort(above.begin(), above.end(), earlier);
  std::size_t between = 0;
  for (std::size_t i = late.first; i < late.end; ++i) {
    const auto next = std::lower_bound(above.begin(), above.end(), &rows[i], earlier);
    if (next == above.end() || (*next)->time > end) continue;
    if ((*next)->time == rows[i].time) {
      between += is_copy(**next, rows[i]) ? 0 : 1;
    } else if (next != above.begin() && (*(next - 1))->time >= begin) {
      ++between;
    }
  }
  if (2 * between < late.end - late.first) return;
  throw InputError(fmt::format(
      "{}: the clock was set back by {:.3f} s at row {} of {}: {} rows from there on have times "
      "between those of rows above, expected one clock: cut the recording there into two",
      what, to_seconds(rows[late.first - 1].time - begin), late.first + 1, rows.size(),
      late.end - late.first));
}

/// bring_into_order() with a remark on each kind of disorder. `what` names the rows: "IMU samples".
/// Throws InputError if a clock was set back.
template <typename Row>
void bring_into_order(std::vector<Row>& rows, const std::string& what,
                      std::vector<std::string>& remarks) {
  require_one_clock(rows, what);
  const std::size_t all = rows.size();
  const OrderCounts counts = bring_into_order(rows);
  if (counts.late > 0) {
    remarks.push_back(fmt::format("{} of {} {} came after later ones: put in order of time",
                                  counts.late, all, what));
  }
  if (counts.repeated > 0) {
    remarks.push_back(fmt::format("{} of {} {} repeat the time of another: left out",
                                  counts.repeated, all, what));
  }
}

/// Removes the rows of a file that are not `known`, with a remark. Throws InputError if none is
/// left.
template <typename Row, typename Known>
void leave_out_unknown(const std::filesystem::path& file, const Known& known,
                       const std::string& what, std::vector<Row>& rows,
                       std::vector<std::string>& remarks) {
  const std::size_t all = rows.size();
  std::erase_if(rows, [&](const Row& row) { return !known(row); });
  const std::size_t lost = all - rows.size();
  if (lost == 0) return;
  if (lost == all) {
    throw InputError(
        fmt::format("{}: none of the {} {} is of finite numbers", file.string(), all, what));
  }
  remarks.push_back(fmt::format("{} of {} {} are not finite numbers: left out", lost, all, what));
}

}  // namespace chasles
