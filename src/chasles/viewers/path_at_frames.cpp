#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/viewers/path_at_frames.hpp>

namespace chasles {
namespace {

// The offset that a run took as exact; 0 also for `auto`, which the run estimates.
double stated_offset(std::string_view summary) {
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  const auto pointer = nlohmann::json::json_pointer("/settings/time_offset");
  if (json.is_discarded() || !json.contains(pointer)) return 0;
  const auto& offset = json.at(pointer);
  return offset.is_number() ? offset.get<double>() : 0;
}

// By the time of each state: its stamp by the cameras' clock, but for those where the run was lost.
std::map<Time, Time> stamps_of_states(const ReportRun& run) {
  const auto& names = run.run.extra_names;
  const auto column =
      static_cast<std::size_t>(std::ranges::find(names, "time_offset") - names.begin());
  const double stated = stated_offset(run.summary);
  std::map<Time, Time> stamps;
  for (const RunState& s : run.run.states) {
    if (s.health == "lost") continue;
    const double offset = column < names.size() ? s.extra[column] : stated;
    if (std::isfinite(offset)) stamps.emplace(s.time, s.time - from_seconds(offset));
  }
  return stamps;
}

Time half_interval(std::span<const Time> stamps) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    gaps.push_back(to_seconds(stamps[i] - stamps[i - 1]));
  }
  return gaps.empty() ? Time::zero() : from_seconds(median(gaps) / 2);
}

// The nearest one. Presumes that there is one.
std::size_t nearest(std::span<const Time> stamps, Time time) {
  const auto after = std::ranges::lower_bound(stamps, time);
  if (after == stamps.begin()) return 0;
  const auto at = static_cast<std::size_t>(after - stamps.begin());
  if (after == stamps.end() || time - stamps[at - 1] < stamps[at] - time) return at - 1;
  return at;
}

}  // namespace

std::vector<std::optional<SmoothedPose>> poses_at_frames(const ReportRun& run, RunPath path,
                                                         std::span<const Time> stamps) {
  const std::map<Time, Time> by_cameras = stamps_of_states(run);
  const Time reach = half_interval(stamps);
  std::vector<std::optional<SmoothedPose>> poses(stamps.size());
  bool any = false;
  for (const SmoothedPose& s : path_poses(run.run, path)) {
    const auto stamp = by_cameras.find(s.time);
    if (stamp == by_cameras.end() || stamps.empty()) continue;
    const std::size_t i = nearest(stamps, stamp->second);
    if (std::max(stamps[i], stamp->second) - std::min(stamps[i], stamp->second) > reach) continue;
    poses[i] = s;
    any = true;
  }
  if (!any) {
    throw InputError(fmt::format(
        "run '{}': no pose belongs to one of the {} frames of the recording, expected the "
        "recording of the run, and a run that was not lost all the time",
        run.run.name, stamps.size()));
  }
  return poses;
}

}  // namespace chasles
