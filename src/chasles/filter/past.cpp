#include <algorithm>
#include <set>
#include <utility>

#include <chasles/filter/fixed_interval.hpp>
#include <chasles/filter/past.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {

PastPose corrected(PastPose pose, const Vector6d& correction, const Matrix6d& covariance) {
  pose.map_T_imu.R = so3::exp(correction.head<3>()) * pose.map_T_imu.R;
  pose.map_T_imu.p += correction.tail<3>();
  pose.covariance = covariance;
  return pose;
}

int Past::add(const Landmark& landmark) {
  states_.emplace_back(PastLandmark{.landmark = landmark});
  ++landmarks_;
  return static_cast<int>(states_.size()) - 1;
}

int Past::add(Time time, const SE3& map_T_imu) {
  states_.emplace_back(PastPose{.time = time, .map_T_imu = map_T_imu});
  return static_cast<int>(states_.size()) - 1;
}

int Past::add(const PriorMap& prior) {
  states_.emplace_back(Frame{.map_T_prior = prior.map_T_prior});
  const int number = static_cast<int>(states_.size()) - 1;
  for (const Landmark& landmark : prior.landmarks) add(landmark);
  return number;
}

const SE3& Past::frame(int number) const {
  return std::get<Frame>(states_[static_cast<std::size_t>(number)]).map_T_prior;
}

bool Past::is_frame(int number) const {
  return std::holds_alternative<Frame>(states_[static_cast<std::size_t>(number)]);
}

const Landmark& Past::landmark(int number) const {
  return std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).landmark;
}

const Past::PastLandmark* Past::past_landmark(int number) const {
  return std::get_if<PastLandmark>(&states_[static_cast<std::size_t>(number)]);
}

void Past::forget(int number) {
  std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).may_return = false;
}

// Or has done so.
bool Past::may_return(int number) const {
  const PastLandmark* landmark = past_landmark(number);
  return landmark != nullptr && landmark->may_return;
}

bool Past::can_return(int number) const {
  return options_.recalls && number >= 0 && number < states() && may_return(number) &&
         !past_landmark(number)->has_returned;
}

// The landmarks that may return, and the frames.
Segment Past::of_recalled(const Segment& segment) const {
  std::vector<int> recalled;
  for (const Segment::Item& item : segment.items) {
    if (may_return(item.number) || is_frame(item.number)) recalled.push_back(item.number);
  }
  return with_items(segment, recalled);
}

void Past::append(Segment segment) {
  if (options_.recalls) {
    chain_.append(of_recalled(segment),
                  [&](int number) { return can_return(number) || is_frame(number); });
  }
  if (options_.records) {
    recorded_bytes_ += segment.bytes();
    records_.push_back({.segment = std::move(segment), .revived = std::move(revived_)});
    if (options_.most_bytes > 0 && recorded_bytes_ > options_.most_bytes) give_up_older_half();
  }
  revived_.clear();
}

Carried Past::recall(const std::vector<int>& numbers) const { return chain_.recall(numbers); }

Carried Past::revive(const std::vector<int>& numbers) {
  Carried revived =
      chain_.revive(numbers, [&](int number) { return can_return(number) || is_frame(number); });
  note_returned(numbers);
  revived_.insert(revived_.end(), numbers.begin(), numbers.end());
  return revived;
}

void Past::note_returned(const std::vector<int>& numbers) {
  for (const int number : numbers) {
    std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).has_returned = true;
  }
  landmarks_ -= static_cast<int>(numbers.size());
}

Past::Estimates Past::estimates(const Segment& latest) const {
  std::vector<Stretch> stretches = recorded();
  stretches.push_back({&latest, &revived_});
  Estimates result = final_;
  append_estimates(smooth_segments(stretches), result);
  return result;
}

std::vector<Stretch> Past::recorded() const {
  std::vector<Stretch> stretches;
  for (const Recorded& record : records_) stretches.push_back({&record.segment, &record.revived});
  return stretches;
}

void Past::append_estimates(std::span<const SmoothedState> smoothed, Estimates& estimates) const {
  for (const SmoothedState& one : smoothed) {
    std::visit(
        Overloaded{[&](const PastLandmark& past) {
                     if (past.has_returned) return;
                     const Landmark& landmark = past.landmark;
                     estimates.landmarks.push_back({.id = landmark.id,
                                                    .p_world = landmark.p_world + one.correction,
                                                    .covariance = one.covariance,
                                                    .observations = landmark.observations});
                   },
                   [&](const PastPose& pose) {
                     estimates.poses.push_back(corrected(pose, one.correction, one.covariance));
                   },
                   [](const Frame&) {}},
        states_[static_cast<std::size_t>(one.number)]);
  }
}

// Its states are estimated from both halves. Landmarks that may return, or have returned since,
// stay, in one segment.
void Past::give_up_older_half() {
  const std::size_t half = std::max<std::size_t>(records_.size() / 2, options_.recalls ? 2 : 1);
  if (records_.size() <= half) return;
  const auto middle = records_.begin() + static_cast<std::ptrdiff_t>(half);
  std::vector<SmoothedState> smoothed = smooth_segments(recorded());
  std::size_t states = 0;
  SegmentChain landmarks;
  std::set<int> returned;
  const auto keeps = [&](int number) { return !returned.contains(number); };
  for (auto record = records_.begin(); record != middle; ++record) {
    states += record->segment.items.size();
    recorded_bytes_ -= record->segment.bytes();
    if (!options_.recalls) continue;
    if (!record->revived.empty()) landmarks.revive(record->revived, keeps);
    returned.insert(record->revived.begin(), record->revived.end());
    landmarks.append(of_recalled(record->segment), keeps);
  }
  smoothed.resize(states);
  if (options_.recalls) {
    std::erase_if(smoothed, [&](const SmoothedState& s) {
      return may_return(s.number) || is_frame(s.number);
    });
  }
  append_estimates(smoothed, final_);
  records_.erase(records_.begin(), middle);
  if (!options_.recalls) return;
  records_.insert(records_.begin(), {.segment = landmarks.composed(keeps), .revived = {}});
  recorded_bytes_ += records_.front().segment.bytes();
}

std::size_t Past::bytes() const { return recorded_bytes_ + chain_.bytes(); }

}  // namespace chasles
