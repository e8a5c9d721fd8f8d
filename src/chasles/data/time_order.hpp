#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <chasles/time.hpp>

namespace chasles {

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

/// The same, with a remark on each kind of disorder. `what` names the rows: "IMU samples".
template <typename Row>
void bring_into_order(std::vector<Row>& rows, const std::string& what,
                      std::vector<std::string>& remarks) {
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

}  // namespace chasles
