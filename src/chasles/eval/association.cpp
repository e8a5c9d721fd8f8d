#include <algorithm>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/association.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewestPairs = 3;

void require_valid(const Trajectory& trajectory, std::string_view name) {
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (!trajectory[i].pose.R.allFinite() || !trajectory[i].pose.p.allFinite()) {
      throw InputError(fmt::format(
          "{}: pose {} (t = {:.6f} s) is not finite; cut the trajectory before it or repair it",
          name, i, to_seconds(trajectory[i].time)));
    }
    if (i > 0 && trajectory[i].time <= trajectory[i - 1].time) {
      throw InputError(fmt::format(
          "{}: time {:.9f} s of pose {} is not after {:.9f} s of the pose before; expected "
          "increasing times",
          name, to_seconds(trajectory[i].time), i, to_seconds(trajectory[i - 1].time)));
    }
  }
}

std::string describe(const Trajectory& trajectory) {
  if (trajectory.empty()) return "no poses";
  return fmt::format("{} poses from {:.3f} to {:.3f} s", trajectory.size(),
                     to_seconds(trajectory.front().time), to_seconds(trajectory.back().time));
}

Time default_tolerance(const Trajectory& a, const Trajectory& b) {
  const Time spacing_a = median_spacing(a);
  const Time spacing_b = median_spacing(b);
  return std::min(spacing_a, spacing_b) / 2;
}

bool overlap(const Trajectory& a, const Trajectory& b) {
  return !a.empty() && !b.empty() && a.front().time <= b.back().time &&
         b.front().time <= a.back().time;
}

std::string likely_cause(const Trajectory& estimate, const Trajectory& truth,
                         const TruthPairing& pairing) {
  const Time spacing = median_spacing(truth);
  if (pairing.pairing == Pairing::kNearest || spacing <= pairing.longest_gap ||
      !overlap(estimate, truth)) {
    return "are both stamped by the same clock?";
  }
  return fmt::format(
      "its poses are {:.3g} s apart; a longer gap (--max-truth-gap) or the nearest stamps "
      "(--pairing nearest) would pair them",
      to_seconds(spacing));
}

// For each stamp of `from`, the index of the nearest stamp in `to` (the earlier one if both are
// equally near). Both in order of time, `to` not empty.
std::vector<std::size_t> nearest(const Trajectory& from, const Trajectory& to) {
  std::vector<std::size_t> result(from.size());
  std::size_t j = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto distance = [&](std::size_t k) {
      return std::chrono::abs(to[k].time - from[i].time);
    };
    while (j + 1 < to.size() && distance(j + 1) < distance(j)) ++j;
    result[i] = j;
  }
  return result;
}

MatchedTrajectories pair_nearest(const Trajectory& estimate, const Trajectory& truth,
                                 Time tolerance) {
  MatchedTrajectories matched;
  if (estimate.empty() || truth.empty()) return matched;
  const std::vector<std::size_t> to_truth = nearest(estimate, truth);
  const std::vector<std::size_t> to_estimate = nearest(truth, estimate);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t j = to_truth[i];
    if (to_estimate[j] != i) continue;
    if (std::chrono::abs(estimate[i].time - truth[j].time) > tolerance) continue;
    matched.estimate.push_back(estimate[i]);
    matched.truth.push_back(truth[j]);
    matched.estimate_index.push_back(i);
  }
  return matched;
}

MatchedTrajectories interpolate(const Trajectory& estimate, const Trajectory& truth,
                                Time longest_gap) {
  MatchedTrajectories matched;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Time time = estimate[i].time;
    const auto pose = pose_at(truth, time, longest_gap);
    if (!pose) continue;
    matched.estimate.push_back(estimate[i]);
    matched.truth.push_back({.time = time, .pose = *pose});
    matched.estimate_index.push_back(i);
    if (!std::ranges::binary_search(truth, time, {}, &StampedPose::time)) ++matched.interpolated;
  }
  return matched;
}

}  // namespace

Time median_spacing(const Trajectory& trajectory) {
  if (trajectory.size() < 2) return Time{0};
  std::vector<Time> spacings(trajectory.size() - 1);
  for (std::size_t i = 0; i < spacings.size(); ++i) {
    spacings[i] = trajectory[i + 1].time - trajectory[i].time;
  }
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::nth_element(spacings.begin(), middle, spacings.end());
  return *middle;
}

MatchedTrajectories associate(const Trajectory& estimate, const Trajectory& truth,
                              const TruthPairing& pairing) {
  require_valid(estimate, "estimate");
  require_valid(truth, "truth");
  const bool nearest = pairing.pairing == Pairing::kNearest;
  const Time tolerance = pairing.tolerance.value_or(default_tolerance(estimate, truth));
  MatchedTrajectories matched = nearest ? pair_nearest(estimate, truth, tolerance)
                                        : interpolate(estimate, truth, pairing.longest_gap);
  if (matched.estimate.size() >= kFewestPairs) return matched;
  throw InputError(fmt::format(
      "only {} poses of the estimate have a truth, expected at least {}; {}; the estimate has {}, "
      "the truth {}: {}",
      matched.estimate.size(), kFewestPairs,
      nearest ? fmt::format("one counts within {:.6f} s of a stamp", to_seconds(tolerance))
              : fmt::format("between stamps up to {:g} s apart it is interpolated",
                            to_seconds(pairing.longest_gap)),
      describe(estimate), describe(truth), likely_cause(estimate, truth, pairing)));
}

std::vector<double> distances_along(const Trajectory& trajectory) {
  std::vector<double> distances(trajectory.size(), 0.0);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    distances[i] = distances[i - 1] + (trajectory[i].pose.p - trajectory[i - 1].pose.p).norm();
  }
  return distances;
}

double path_length(const Trajectory& trajectory) {
  return trajectory.empty() ? 0 : distances_along(trajectory).back();
}

}  // namespace chasles
