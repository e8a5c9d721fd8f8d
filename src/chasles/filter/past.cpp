#include <algorithm>
#include <utility>

#include <chasles/filter/fixed_interval.hpp>
#include <chasles/filter/past.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {
namespace {

std::size_t bytes_of(const Segment& s) {
  return sizeof(double) * static_cast<std::size_t>(s.X.size() + s.G.size() + s.g.size());
}

}  // namespace

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

const Landmark& Past::landmark(int number) const {
  return std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).landmark;
}

void Past::append(Segment segment) {
  if (options_.recalls) {
    std::vector<int> landmarks;
    for (const Segment::Item& item : segment.items) {
      if (item.size == 3) landmarks.push_back(item.number);
    }
    chain_.push_back(with_items(segment, landmarks));
    // As a binary counter carries: each segment takes part in few compositions.
    while (chain_.size() > 1 && chain_[chain_.size() - 2].length <= chain_.back().length) {
      Segment younger = std::move(chain_.back());
      chain_.pop_back();
      chain_.back() = compose(chain_.back(), younger);
    }
  }
  if (options_.records) {
    recorded_bytes_ += bytes_of(segment);
    records_.push_back({.segment = std::move(segment), .revived = std::move(revived_)});
    if (options_.most_bytes > 0 && recorded_bytes_ > options_.most_bytes) give_up_older_half();
  }
  revived_.clear();
}

Carried Past::recall(const std::vector<int>& numbers) const {
  Carried past;
  for (const Segment& segment : chain_) carry(past, segment, numbers);
  return past;
}

Carried Past::revive(const std::vector<int>& numbers) {
  Carried past;
  for (Segment& segment : chain_) {
    const Carried before = past;
    carry(past, segment, numbers);
    if (before.rows() > 0) pass_through(segment, before.C);
    std::vector<int> own;
    for (const Segment::Item& item : segment.items) {
      if (std::ranges::binary_search(numbers, item.number)) own.push_back(item.number);
    }
    take_along(segment, own);
  }
  note_returned(numbers);
  revived_.insert(revived_.end(), numbers.begin(), numbers.end());
  return past;
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
                   }},
        states_[static_cast<std::size_t>(one.number)]);
  }
}

// Its states are estimated from both halves.
void Past::give_up_older_half() {
  const std::vector<SmoothedState> smoothed = smooth_segments(recorded());
  const auto middle = records_.begin() + static_cast<std::ptrdiff_t>(records_.size() / 2);
  std::size_t states = 0;
  for (auto record = records_.begin(); record != middle; ++record) {
    states += record->segment.items.size();
  }
  append_estimates(std::span(smoothed).first(states), final_);
  for (auto record = records_.begin(); record != middle; ++record) {
    recorded_bytes_ -= bytes_of(record->segment);
  }
  records_.erase(records_.begin(), middle);
}

std::size_t Past::bytes() const {
  std::size_t sum = recorded_bytes_;
  for (const Segment& segment : chain_) sum += bytes_of(segment);
  return sum;
}

}  // namespace chasles
