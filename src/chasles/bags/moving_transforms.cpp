#include <algorithm>
#include <cmath>

#include <chasles/bags/moving_transforms.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

bool MovingTransform::is_constant() const {
  constexpr double kShift = 1e-4;              // [m]
  constexpr double kTurn = 0.01 * M_PI / 180;  // [rad]
  return shift <= kShift && turn <= kTurn;
}

void MovingTransforms::add(RosTransform&& one) {
  constexpr std::size_t kMostFrames = 10'000;
  std::pair<std::string, std::string> frames(one.parent, one.child);
  const auto known = of_frames_.find(frames);
  if (known == of_frames_.end()) {
    if (all.size() == kMostFrames) return;
    of_frames_.emplace(std::move(frames), all.size());
    all.push_back({.first = std::move(one), .count = 1});
    return;
  }
  MovingTransform& moving = all[known->second];
  const SE3& first = moving.first.parent_T_child;
  ++moving.count;
  moving.shift = std::max(moving.shift, (one.parent_T_child.p - first.p).norm());
  moving.turn = std::max(moving.turn, so3::log(first.R.transpose() * one.parent_T_child.R).norm());
}

}  // namespace chasles
