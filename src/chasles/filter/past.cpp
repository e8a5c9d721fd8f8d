#include <algorithm>
#include <utility>

#include <chasles/filter/past.hpp>
#include <chasles/filter/past_estimates_detail.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/overloaded.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::VectorXd;

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
    records_.push_back({.segment = std::move(segment), .revived = std::move(revived_)});
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
  std::vector<filter_detail::Stretch> stretches;
  for (const Recorded& record : records_) stretches.push_back({&record.segment, &record.revived});
  stretches.push_back({&latest, &revived_});
  Estimates result;
  std::vector<filter_detail::Smoothed> all = filter_detail::smooth(stretches);
  for (const filter_detail::Smoothed& one : all) {
    std::visit(Overloaded{[&](const PastLandmark& past) {
                            if (past.has_returned) return;
                            const Landmark& landmark = past.landmark;
                            result.landmarks.push_back(
                                {.id = landmark.id,
                                 .p_world = landmark.p_world + one.correction,
                                 .covariance = one.covariance,
                                 .observations = landmark.observations});
                          },
                          [&](const PastPose& pose) {
                            result.poses.push_back(
                                {.time = pose.time,
                                 .map_T_imu = {so3::exp(one.correction.head<3>()) *
                                                   pose.map_T_imu.R,
                                               pose.map_T_imu.p + one.correction.tail<3>()},
                                 .covariance = one.covariance});
                          }},
               states_[static_cast<std::size_t>(one.number)]);
  }
  return result;
}

std::size_t Past::bytes() const {
  const auto of = [](const Segment& s) {
    return sizeof(double) * static_cast<std::size_t>(s.X.size() + s.G.size() + s.g.size());
  };
  std::size_t sum = 0;
  for (const Segment& segment : chain_) sum += of(segment);
  for (const Recorded& record : records_) sum += of(record.segment);
  return sum;
}

}  // namespace chasles
