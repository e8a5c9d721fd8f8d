#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/live/comparison.hpp>

namespace chasles {

PoseError coordinates_of(const std::string& summary) {
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  if (!json.is_object() || !json.contains("chart") || !json["chart"].is_string()) {
    return PoseError::kStandard;
  }
  return pose_error_of(json["chart"].get<std::string>());
}

GrowingComparison::GrowingComparison(Trajectory truth, const TruthPairing& pairing,
                                     PoseError coordinates, bool level)
    : truth_(std::move(truth)),
      pairing_(pairing),
      coordinates_(coordinates),
      level_(level),
      truth_spacing_(median_spacing(truth_)) {}

void GrowingComparison::extend(const std::vector<RunState>& states) {
  if (truth_.empty() || states.size() < 2) return;
  while (error_.size() < states.size()) {
    const std::size_t i = std::max<std::size_t>(error_.size(), 1);
    const Time spacing = states[i].time - states[i - 1].time;
    add(states[error_.size()], std::min(spacing, truth_spacing_) / 2);
  }
}

std::optional<SE3> GrowingComparison::true_pose(const RunState& state, Time tolerance) const {
  if (pairing_.pairing == Pairing::kInterpolate) {
    return pose_at(truth_, state.time, pairing_.longest_gap);
  }
  const auto after = std::ranges::lower_bound(truth_, state.time, {}, &StampedPose::time);
  const auto distance = [&](auto pose) { return std::chrono::abs(pose->time - state.time); };
  auto nearest = after;
  if (after == truth_.end() ||
      (after != truth_.begin() && distance(after - 1) <= distance(after))) {
    --nearest;
  }
  return distance(nearest) <= tolerance ? std::optional(nearest->pose) : std::nullopt;
}

void GrowingComparison::add(const RunState& state, Time tolerance) {
  const std::optional<SE3> truth = true_pose(state, tolerance);
  const bool finite = state.world_T_imu.R.allFinite() && state.world_T_imu.p.allFinite();
  if (!truth || !finite) {
    error_.push_back(Vector6d::Constant(kNaN));
    nees_.push_back({.position = kNaN, .attitude = kNaN, .pose = kNaN});
    placed_.emplace_back();
    return;
  }
  if (!world_T_truth_) {
    const MatchedTrajectories first = {.estimate = {{state.time, state.world_T_imu}},
                                       .truth = {{state.time, *truth}},
                                       .estimate_index = {0}};
    world_T_truth_ = align(first, level_ ? Alignment::kFirstLevel : Alignment::kFirstPose)
                         .truth_T_estimate.inverse();
  }
  const SE3 placed = *world_T_truth_ * *truth;
  placed_.emplace_back(placed);
  error_.push_back(pose_error(PoseError::kStandard, placed, state.world_T_imu));
  nees_.push_back(pose_nees(coordinates_, placed, state.world_T_imu, state.pose_covariance));
}

AgainstTruth GrowingComparison::of(const std::vector<std::size_t>& states) const {
  AgainstTruth out;
  out.nees.definition = coordinates_;
  out.world_T_truth_first = out.world_T_truth_fit = *world_T_truth_;
  for (const std::size_t i : states) {
    out.error.push_back(error_[i]);
    out.nees_pose.push_back(nees_[i].pose);
    out.nees_attitude.push_back(nees_[i].attitude);
    out.nees_position.push_back(nees_[i].position);
  }
  return out;
}

}  // namespace chasles
