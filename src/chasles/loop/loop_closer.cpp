#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/loop/loop_closer.hpp>

namespace chasles {
namespace {

// Every return passes all segments of the past. So landmarks are looked for now and then, several
// at a time. A proposed place in a map waits for its confirmation alone.
constexpr Time kBetweenImages = std::chrono::milliseconds(300);
constexpr Time kWhileProposed = std::chrono::milliseconds(100);
constexpr Time kBetweenIds = std::chrono::milliseconds(500);

void put_into_state(std::vector<int> numbers, int frame, Ekf& filter, LandmarkRecords& records) {
  std::ranges::sort(numbers);
  filter.revive(numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) records.push_back({.seen = frame});
}

// Each landmark of a considered map that has been in the state keeps its rows in it. Those that
// left earliest give theirs up, and do not return: that would count their errors as new ones.
void bound_considered(Ekf& filter, PastLandmarks& past) {
  constexpr std::size_t kMostAway = 100;
  const auto& considered = filter.state().considered;
  while (considered && considered->away.size() > kMostAway) {
    const Landmark& first = considered->away.front();
    past.erase(first.id);
    filter.bar_return(std::array{*first.considered});
  }
}

}  // namespace

LoopCloser::LoopCloser(const LoopSettings& settings, std::vector<Camera> cameras,
                       std::shared_ptr<const LandmarkMap> prior)
    : settings_(settings),
      cameras_(std::move(cameras)),
      choice_(settings.recognisable),
      placer_(settings.recognise == Recognise::kAppearance ? std::move(prior) : nullptr) {}

void LoopCloser::start_in_map(Ekf& filter, Time time) {
  if (!placer_.searching()) return;
  placer_.propose_nav();
  place_map(filter, time);
}

std::span<const PixelObservation> LoopCloser::renamed(const FeatureFrame& frame) {
  if (known_as_.empty()) return frame.pixels;
  renamed_.assign(frame.pixels.begin(), frame.pixels.end());
  for (PixelObservation& o : renamed_) {
    const auto known = known_as_.find(o.landmark);
    if (known != known_as_.end()) o.landmark = known->second;
  }
  return renamed_;
}

const PixelObservation& LoopCloser::original(const FeatureFrame& frame,
                                             const PixelObservation& o) const {
  if (known_as_.empty() || renamed_.size() != frame.pixels.size()) return o;
  return frame.pixels[static_cast<std::size_t>(&o - renamed_.data())];
}

std::optional<LoopReturn> LoopCloser::search(
    const FeatureFrame& frame, const std::vector<const PixelObservation*>& observations,
    const Ekf& filter, const FrameMoment& at) {
  switch (settings_.recognise) {
    case Recognise::kIds:
      return search_ids(observations, at.now);
    case Recognise::kAppearance:
      return search_images(frame, observations, filter, at);
    case Recognise::kNone:
      break;
  }
  return std::nullopt;
}

// Past landmarks whose ids have come into view again.
std::optional<LoopReturn> LoopCloser::search_ids(
    const std::vector<const PixelObservation*>& observations, Time now) {
  if (searched_ && now - *searched_ < kBetweenIds) return std::nullopt;
  std::vector<int> numbers;
  for (const PixelObservation* o : observations) {
    const auto known = past_.find(o->landmark);
    if (known == past_.end()) continue;
    numbers.push_back(known->second.number);
    past_.erase(known);
  }
  if (numbers.empty()) return std::nullopt;
  searched_ = now;
  return LoopReturn{.numbers = std::move(numbers)};
}

// Past landmarks that resemble something that camera 0 observes.
std::optional<LoopReturn> LoopCloser::search_images(
    const FeatureFrame& frame, const std::vector<const PixelObservation*>& observations,
    const Ekf& filter, const FrameMoment& at) {
  const bool has_image =
      frame.images && !frame.images->images.empty() && !frame.images->images.front().empty();
  const Time interval = placer_.proposed() ? kWhileProposed : kBetweenImages;
  if (!has_image || (searched_ && at.now - *searched_ < interval)) return std::nullopt;
  searched_ = at.now;
  std::vector<ObservedLandmark> observed =
      observed_landmarks(describer_, cameras_, filter, frame.images->images.front(), observations);
  const Surroundings here{
      .filter = filter, .cameras = cameras_, .observed = observed, .past = past_, .now = at.now};
  std::optional<LoopReturn> found;
  if (placer_.searching()) found = search_map(here, at.by_imu);
  if (!found) found = search_among(past_, compatible_, here, at.by_imu);
  if (found) {
    found->observed = std::move(observed);  // close() notes their views
  } else {
    note_views(observed);
  }
  return found;
}

void LoopCloser::note_views(const std::vector<ObservedLandmark>& observed) {
  for (const ObservedLandmark& o : observed) {
    if (!known_as_.contains(o.id)) appearances_[o.id].add(o.view);
  }
}

// Landmarks of the map, at its proposed place.
std::optional<LoopReturn> LoopCloser::search_map(const Surroundings& here, Time by_imu) {
  if (!placer_.proposed()) placer_.propose(here);
  if (!placer_.proposed()) return std::nullopt;
  auto found = search_among(placer_.points(), placer_.compatible(), here, by_imu);
  if (!found) placer_.note_failure();
  return found;
}

// Whether some of these past landmarks are in view.
std::optional<LoopReturn> LoopCloser::search_among(PastLandmarks& past,
                                                   CompatibleMatches& compatible,
                                                   const Surroundings& here, Time by_imu) {
  std::vector<LoopCandidate> candidates =
      similar_landmarks(cameras_, here.filter.state(), past, here.observed);
  if (candidates.size() < kLeastReturns) {
    compatible.clear();
    return std::nullopt;
  }
  const bool of_map = &past != &past_;
  LoopInnovations innovations =
      loop_innovations(cameras_.front(), here.filter, candidates,
                       of_map ? placer_.known_points(here.filter, candidates)
                              : known_landmarks(here.filter, candidates),
                       here.observed);
  AcceptedMatches accepted = accepted_matches(innovations, candidates, here.observed, here.p_nav(),
                                              settings_.noise, compatible);
  if (accepted.recognised) recognised_.push_back(by_imu);
  if (accepted.matches.empty()) return std::nullopt;
  if (of_map && !placer_.finds_again(here, innovations, accepted.matches, candidates)) {
    compatible.clear();
    return std::nullopt;
  }
  return LoopReturn{.numbers = {},
                    .candidates = std::move(candidates),
                    .innovations = std::move(innovations),
                    .accepted = std::move(accepted.matches),
                    .of_map = of_map};
}

void LoopCloser::leave_out(const LoopReturn& found, Ekf& filter) {
  if (found.of_map) {
    placer_.reject();
    return;
  }
  std::vector<int> numbers = found.numbers;
  for (const int i : found.accepted) {
    const ProposedMatch& match = found.innovations.matches[static_cast<std::size_t>(i)];
    const LoopCandidate& old = found.candidates[static_cast<std::size_t>(match.landmark)];
    numbers.push_back(old.past->number);
    past_.erase(old.id);
  }
  filter.bar_return(numbers);
  if (found.by_appearance()) compatible_.clear();
}

void LoopCloser::close(LoopReturn& found, Ekf& filter, LandmarkRecords& records,
                       const FrameMoment& at) {
  if (!found.by_appearance()) {
    returned_.clear();
    for (const int number : found.numbers) returned_.push_back(filter.past().landmark(number).id);
    put_into_state(std::move(found.numbers), at.frame, filter, records);
    return;
  }
  if (found.of_map) {
    const Surroundings here{.filter = filter,
                            .cameras = cameras_,
                            .observed = found.observed,
                            .past = past_,
                            .now = at.now};
    placer_.refine(here, settings_.noise.gate, found.innovations, found.accepted, found.candidates);
    place_map(filter, at.by_imu);
  }
  replace_observed(found, filter, records, at);
  note_views(found.observed);
}

// The place is accepted: the map's landmarks become past landmarks of the filter.
void LoopCloser::place_map(Ekf& filter, Time by_imu) {
  const int number = settings_.prior_map == PriorMapUse::kConsidered
                         ? filter.consider(placer_.placed_map())
                         : filter.add_past(placer_.placed_map());
  for (auto& [id, point] : placer_.points()) point.number += number + 1;
  past_.merge(placer_.points());
  placed_ = PlacedMap(placer_.finish(by_imu), number);
}

// The landmark of the state is the past one: it gives way, and its track continues as the past one.
void LoopCloser::replace_observed(LoopReturn& found, Ekf& filter, LandmarkRecords& records,
                                  const FrameMoment& at) {
  std::vector<int> numbers, gone;
  returned_.clear();
  for (const int i : found.accepted) {
    const ProposedMatch& match = found.innovations.matches[static_cast<std::size_t>(i)];
    const ObservedLandmark& s = found.observed[static_cast<std::size_t>(match.observation)];
    LoopCandidate& old = found.candidates[static_cast<std::size_t>(match.landmark)];
    for (auto& [track, landmark] : known_as_) {
      if (landmark == s.id) landmark = old.id;
    }
    known_as_[s.id] = old.id;
    returned_.push_back(old.id);
    numbers.push_back(old.past->number);
    gone.push_back(s.index);
    appearances_.erase(s.id);
    Appearance& appearance = appearances_[old.id];
    appearance = std::move(old.past->appearance);
    appearance.add(s.view);
    past_.erase(old.id);
  }
  std::ranges::sort(gone);
  remove(records, gone);
  filter.remove(gone);
  put_into_state(std::move(numbers), at.frame, filter, records);
  const State& x = filter.state();
  const std::size_t first = x.landmarks.size() - found.accepted.size();
  for (std::size_t i = first; i < x.landmarks.size(); ++i) {
    filter.add_noise(static_cast<int>(i), drift_noise(cameras_.front(), x, x.landmarks[i],
                                                      kOtherPoint * kOtherPoint, 0));
  }
  closures_.push_back(
      {.time = at.by_imu,
       .landmarks = static_cast<int>(found.accepted.size()),
       .square = joint_square(found.accepted, found.innovations.r, found.innovations.S,
                              returned_variance(settings_.noise.gate)),
       .dof = 2 * static_cast<int>(found.accepted.size())});
}

void LoopCloser::note_change(const SE3& before, const SE3& after) {
  closures_.back().moved = (after.p - before.p).norm();
  closures_.back().turned = so3::log(after.R * before.R.transpose()).norm();
}

void LoopCloser::note_undone(std::span<const Closure> closures) {
  for (Closure closure : closures) {
    closure.undone = true;
    closures_.push_back(closure);
  }
  std::ranges::stable_sort(closures_, {}, &Closure::time);
}

void LoopCloser::note_leaving(std::span<const int> leaving, const Ekf& filter,
                              const LandmarkRecords& records, Time now) {
  not_returning_.clear();
  rejected_.clear();
  if (settings_.recognise == Recognise::kNone) return;
  const State& x = filter.state();
  int number = filter.past().states();
  for (const int index : leaving) {
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(index)];
    auto appearance = appearances_.extract(landmark.id);
    if (!landmark.has_place()) continue;
    PastLandmark past{.number = landmark.considered ? *landmark.considered : number++, .left = now};
    bool returns = records[static_cast<std::size_t>(index)].rejected < settings_.max_rejections;
    if (!returns) {
      rejected_.push_back(landmark.id);
      std::erase_if(known_as_, [&](const auto& known) { return known.second == landmark.id; });
      choice_.give_up(landmark.id);
    }
    if (settings_.recognise == Recognise::kAppearance) {
      const Eigen::Vector3d p_world = x.p_world(landmark);
      past.p_nav = x.nav_T_world ? *x.nav_T_world * p_world : p_world;
      if (!appearance.empty()) past.appearance = std::move(appearance.mapped());
      returns = returns && may_return(landmark, past, filter);
    }
    if (returns) {
      past_[landmark.id] = std::move(past);
    } else {
      not_returning_.push_back(past.number);
    }
  }
  for (const LandmarkId id : choice_.thin()) {
    const auto past = past_.extract(id);
    if (!past.empty()) not_returning_.push_back(past.mapped().number);
  }
}

// By its appearance, if it is chosen among its neighbours.
bool LoopCloser::may_return(const Landmark& landmark, const PastLandmark& past, const Ekf& filter) {
  const double distance = (past.p_nav - nav_T_camera(cameras_, filter.state(), 0).p).norm();
  return !past.appearance.empty() && landmark.observations >= kLeastObservations &&
         (landmark.id >= kFirstMapId ||
          choice_.choose(landmark.id, past.p_nav, distance, past.appearance.views().front().from));
}

void LoopCloser::bar_others(Ekf& filter) {
  filter.bar_return(not_returning_);
  bound_considered(filter, past_);
}

LandmarkMap LoopCloser::landmark_map(const Ekf& filter, Time end, std::optional<Time> until) const {
  return saved_map(
      {.filter = filter, .past = past_, .appearances = appearances_, .placed = placed_}, cameras_,
      settings_.recognisable, end, until);
}

}  // namespace chasles
