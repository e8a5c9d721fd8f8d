#include <algorithm>

#include <chasles/lie/so3.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {
namespace {

constexpr Time kRounding = std::chrono::microseconds(100);

SE3 between(const StampedPose& a, const StampedPose& b, Time time) {
  const double part = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  SE3 pose;
  pose.p = a.pose.p + part * (b.pose.p - a.pose.p);
  pose.R = a.pose.R * so3::exp(part * so3::log(a.pose.R.transpose() * b.pose.R));
  return pose;
}

}  // namespace

std::optional<SE3> pose_at(const Trajectory& trajectory, Time time, Time longest_gap) {
  const auto next = std::ranges::lower_bound(trajectory, time, {}, &StampedPose::time);
  const bool has_next = next != trajectory.end(), has_before = next != trajectory.begin();
  if (has_next && next->time == time) return next->pose;
  if (has_next && has_before && next->time - std::prev(next)->time <= longest_gap) {
    return between(*std::prev(next), *next, time);
  }
  if (has_before && time - std::prev(next)->time <= kRounding) return std::prev(next)->pose;
  if (has_next && next->time - time <= kRounding) return next->pose;
  return std::nullopt;
}

}  // namespace chasles
