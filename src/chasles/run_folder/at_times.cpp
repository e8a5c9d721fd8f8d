#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include <chasles/run_folder/at_times.hpp>

namespace chasles {
namespace {

using LostTimes = std::set<Time>;

LostTimes lost_times(const Run& run) {
  LostTimes lost;
  for (const RunState& state : run.states) {
    if (state.health == "lost") lost.insert(state.time);
  }
  return lost;
}

bool is_lost_between(const LostTimes& lost, Time first, Time last) {
  const auto found = lost.lower_bound(first);
  return found != lost.end() && *found <= last;
}

double mixed(double a, double b, double part) { return a + part * (b - a); }

// What a pose of either path has.
template <typename Row>
Row mixed_pose(const Row& a, const Row& b, double part) {
  Row row;
  row.world_T_imu.p = a.world_T_imu.p + part * (b.world_T_imu.p - a.world_T_imu.p);
  row.world_T_imu.R =
      a.world_T_imu.R * so3::exp(part * so3::log(a.world_T_imu.R.transpose() * b.world_T_imu.R));
  row.pose_covariance = (1 - part) * a.pose_covariance + part * b.pose_covariance;
  return row;
}

SmoothedPose mixed_row(const SmoothedPose& a, const SmoothedPose& b, double part) {
  return mixed_pose(a, b, part);
}

RunState mixed_row(const RunState& a, const RunState& b, double part) {
  RunState row = mixed_pose(a, b, part);
  for (std::size_t k = 0; k < a.extra.size(); ++k) {
    row.extra.push_back(mixed(a.extra[k], b.extra[k], part));
    row.extra_sigma.push_back(std::sqrt(
        mixed(a.extra_sigma[k] * a.extra_sigma[k], b.extra_sigma[k] * b.extra_sigma[k], part)));
  }
  row.health = a.health == b.health ? a.health : "degraded";
  row.landmarks = a.landmarks;
  row.in_state = a.in_state;
  return row;
}

template <typename Row>
RowAt<Row> row_at(const std::vector<Row>& path, const LostTimes& lost, Time time, Time gap) {
  const auto next = std::ranges::lower_bound(path, time, {}, &Row::time);
  RowAt<Row> at;
  if (next != path.end() && next->time == time) {
    at = {.row = *next, .known = !is_lost_between(lost, time, time)};
  } else if (next == path.begin() || next == path.end()) {
    at.row = next == path.begin() ? *next : *std::prev(next);
  } else {
    const Row &a = *std::prev(next), &b = *next;
    at.known = b.time - a.time <= gap && !is_lost_between(lost, a.time, b.time);
    const double part = to_seconds(time - a.time) / to_seconds(b.time - a.time);
    at.row = at.known ? mixed_row(a, b, part) : part < 0.5 ? a : b;
  }
  at.row.time = time;
  return at;
}

template <typename Row>
std::vector<RowAt<Row>> rows_at(const std::vector<Row>& path, const Run& run,
                                std::span<const Time> times, Time gap) {
  std::vector<RowAt<Row>> rows;
  if (path.empty()) return rows;
  const LostTimes lost = lost_times(run);
  for (const Time time : times) rows.push_back(row_at(path, lost, time, gap));
  return rows;
}

}  // namespace

std::vector<RowAt<RunState>> states_at(const Run& run, std::span<const Time> times,
                                       Time longest_gap) {
  return rows_at(run.states, run, times, longest_gap);
}

std::vector<RowAt<SmoothedPose>> smoothed_at(const Run& run, std::span<const Time> times,
                                             Time longest_gap) {
  return rows_at(run.smoothed, run, times, longest_gap);
}

}  // namespace chasles
