#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <chasles/slam/inertial_slam.hpp>

// Landmarks that leave the state, and return (docs/recognition.md).
namespace chasles {
namespace {

using Eigen::Vector3d;

constexpr Time kIdsInterval = std::chrono::milliseconds(500);

}  // namespace

// Landmarks that leave the state. One that the gate has rejected was no point, or has become
// another.
void InertialSlam::note_inactive(std::span<const int> leaving) {
  std::vector<int>& marginalised = work_.marginalised;
  marginalised.clear();
  rejected_.clear();
  if (settings_.recognise == Recognise::kNone) return;
  const State& x = filter_.state();
  int number = filter_.past().states();
  for (const int index : leaving) {
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(index)];
    auto appearance = appearances_.extract(landmark.id);
    if (!landmark.has_place()) continue;
    InactiveLandmark inactive{.number = landmark.considered ? *landmark.considered : number++,
                              .left = now_};
    bool returns = last_[static_cast<std::size_t>(index)].rejected < settings_.max_rejections;
    if (!returns) {
      rejected_.push_back(landmark.id);
      std::erase_if(known_as_, [&](const auto& known) { return known.second == landmark.id; });
      choice_.give_up(landmark.id);
    }
    if (settings_.recognise == Recognise::kAppearance) {
      const Vector3d p_world = x.p_world(landmark);
      inactive.p_nav = x.nav_T_world ? *x.nav_T_world * p_world : p_world;
      if (!appearance.empty()) inactive.appearance = std::move(appearance.mapped());
      const double distance = (inactive.p_nav - nav_T_camera(0).p).norm();
      returns =
          returns && !inactive.appearance.empty() && landmark.observations >= kLeastObservations &&
          (landmark.id >= kFirstMapId || choice_.choose(landmark.id, inactive.p_nav, distance,
                                                        inactive.appearance.views().front().from));
    }
    if (returns) {
      inactive_[landmark.id] = std::move(inactive);
    } else {
      marginalised.push_back(inactive.number);
    }
  }
  for (const LandmarkId id : choice_.thin()) {
    const auto inactive = inactive_.extract(id);
    if (!inactive.empty()) marginalised.push_back(inactive.mapped().number);
  }
}

// Each landmark of a considered map that has been in the state keeps its rows in it. Those that
// left earliest give theirs up, and do not return: that would count their errors as new ones.
void InertialSlam::bound_considered() {
  constexpr std::size_t kMostAway = 100;
  const auto& considered = filter_.state().considered;
  while (considered && considered->away.size() > kMostAway) {
    const Landmark& first = considered->away.front();
    inactive_.erase(first.id);
    filter_.marginalise(std::array{*first.considered});
  }
}

// The frame's observations, with those of recognised landmarks under their first ids.
std::span<const PixelObservation> InertialSlam::renamed(const FeatureFrame& frame) {
  if (known_as_.empty()) return frame.pixels;
  work_.renamed.assign(frame.pixels.begin(), frame.pixels.end());
  for (PixelObservation& o : work_.renamed) {
    const auto known = known_as_.find(o.landmark);
    if (known != known_as_.end()) o.landmark = known->second;
  }
  return work_.renamed;
}

// The outcomes are those of the frame's observations, under the ids of their tracks.
void InertialSlam::name_outcomes(const FeatureFrame& frame,
                                 const std::vector<const PixelObservation*>& observations) {
  if (known_as_.empty() || work_.renamed.size() != frame.pixels.size()) return;
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    const auto index = static_cast<std::size_t>(observations[i] - work_.renamed.data());
    outcomes_[i].observation = frame.pixels[index];
  }
}

// Past landmarks whose ids have come into view again return before the update of the frame. Whether
// there are any.
bool InertialSlam::revive_ids(const std::vector<const PixelObservation*>& observations) {
  if (searched_ && now_ - *searched_ < kIdsInterval) return false;
  std::vector<int> numbers;
  for (const PixelObservation* o : observations) {
    const auto known = inactive_.find(o->landmark);
    if (known == inactive_.end()) continue;
    numbers.push_back(known->second.number);
    inactive_.erase(known);
  }
  if (numbers.empty()) return false;
  searched_ = now_;
  without_ = std::make_shared<InertialSlam>(*this);
  without_->filter_.marginalise(numbers);
  returned_.clear();
  for (const int number : numbers) returned_.push_back(filter_.past().landmark(number).id);
  revive(std::move(numbers));
  return true;
}

void InertialSlam::revive(std::vector<int> numbers) {
  std::ranges::sort(numbers);
  filter_.revive(numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) last_.push_back({.seen = frame_});
}

void InertialSlam::note_undone(std::span<const Closure> closures) {
  for (Closure closure : closures) {
    closure.undone = true;
    closures_.push_back(closure);
  }
  std::ranges::stable_sort(closures_, {}, &Closure::time);
}

}  // namespace chasles
