#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <chasles/base/overloaded.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/past/fixed_interval.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::MatrixXd;

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
  states_.emplace_back(LeftPose{.time = time, .map_T_imu = map_T_imu});
  return static_cast<int>(states_.size()) - 1;
}

int Past::add(PriorMap prior, bool are_items) {
  const std::vector<Landmark> landmarks = prior.landmarks;
  const int frame = states();
  states_.emplace_back(std::move(prior));
  for (const Landmark& landmark : landmarks) {
    states_.emplace_back(PastLandmark{.landmark = landmark,
                                      .frame = are_items ? std::nullopt : std::optional(frame)});
    ++landmarks_;
  }
  return frame;
}

const PriorMap& Past::prior(int frame) const {
  return std::get<PriorMap>(states_[static_cast<std::size_t>(frame)]);
}

bool Past::is_frame(int number) const {
  return std::holds_alternative<PriorMap>(states_[static_cast<std::size_t>(number)]);
}

std::optional<int> Past::frame_of(int number) const {
  const PastLandmark* landmark = past_landmark(number);
  return landmark == nullptr ? std::nullopt : landmark->frame;
}

const Landmark& Past::landmark(int number) const {
  return std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).landmark;
}

const Past::PastLandmark* Past::past_landmark(int number) const {
  return std::get_if<PastLandmark>(&states_[static_cast<std::size_t>(number)]);
}

void Past::bar_return(int number) {
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

void Past::append(Segment segment, const MatrixXd& end) {
  if (options_.recalls) {
    chain_.append(of_recalled(segment),
                  [&](int number) { return can_return(number) || is_frame(number); });
  }
  if (options_.records && !options_.recalls) {
    run_.append(std::move(segment), end);
    if (options_.most_bytes > 0 && run_.bytes() > options_.most_bytes) {
      run_.give_up_older_half([&](const SmoothedState& one) { append_estimate(one, final_); });
    }
  } else if (options_.records) {
    recorded_bytes_ += segment.bytes();
    records_.push_back(std::make_shared<Recorded>(
        Recorded{.segment = std::move(segment), .revived = std::move(revived_)}));
    if (options_.most_bytes > 0 && recorded_bytes_ > options_.most_bytes) give_up_older_half();
  }
  revived_.clear();
}

std::vector<int> Past::sources(const std::vector<int>& numbers) const {
  std::set<int> sources;
  for (const int number : numbers) sources.insert(frame_of(number).value_or(number));
  return {sources.begin(), sources.end()};
}

Carried Past::recall(const std::vector<int>& sources) const { return chain_.recall(sources); }

Carried Past::derived(const Carried& sources, const std::vector<int>& numbers) const {
  const bool same = std::ranges::equal(sources.items, numbers, {}, &Segment::Item::number);
  if (same) return sources;
  Index rows = 0;
  Carried result;
  for (const int number : numbers) {
    const auto source = std::ranges::find(sources.items, number, &Segment::Item::number);
    const int size = frame_of(number) ? 3 : source->size;
    result.items.push_back({.number = number, .size = size});
    rows += size;
  }
  MatrixXd A = MatrixXd::Zero(rows, sources.rows()), own = MatrixXd::Zero(rows, rows);
  Index at = 0;
  for (const Segment::Item& item : result.items) {
    const auto frame = frame_of(item.number);
    Index column = 0;
    for (const Segment::Item& source : sources.items) {
      if (source.number == frame.value_or(item.number)) {
        auto block = A.block(at, column, item.size, source.size);
        if (frame) {
          const DerivedItem derived = derived_item(*frame, item.number);
          block = derived.by_source;
          own.block<3, 3>(at, at) = derived.own;
        } else {
          block.setIdentity();
        }
      }
      column += source.size;
    }
    at += item.size;
  }
  const MatrixXd A_transposed = A.transpose();
  result.C = dense::product(A, sources.C);
  result.P = dense::product(A, dense::product(sources.P, A_transposed)) + own;
  result.correction = A * sources.correction;
  return result;
}

DerivedItem Past::derived_item(int frame, int number) const {
  const PriorMap& map = prior(frame);
  const int index = number - frame - 1;
  return {.item = {.number = number, .size = 3},
          .by_source = map.shared.middleRows<3>(6 + 3 * index),
          .own = map.own[static_cast<std::size_t>(index)]};
}

// Landmarks of prior maps that return for the first time: items of their own from now on.
void Past::make_items(const std::vector<int>& numbers) {
  std::map<int, std::vector<DerivedItem>> by_frame;
  for (const int number : numbers) {
    if (const auto frame = frame_of(number)) {
      by_frame[*frame].push_back(derived_item(*frame, number));
      std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).frame.reset();
    }
  }
  for (const auto& [frame, derived] : by_frame) {
    chain_.derive(frame, derived);
    for (std::shared_ptr<Recorded>& record : records_) {
      if (record->segment.place(frame) < 0) continue;
      recorded_bytes_ -= record->segment.bytes();
      record = std::make_shared<Recorded>(
          Recorded{with_derived(record->segment, frame, derived), record->revived});
      recorded_bytes_ += record->segment.bytes();
    }
  }
}

Carried Past::revive(const std::vector<int>& numbers) {
  make_items(numbers);
  Carried revived = chain_.revive(numbers);
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

void Past::note_left(int number) {
  std::get<PastLandmark>(states_[static_cast<std::size_t>(number)]).has_returned = false;
  ++landmarks_;
}

Past::Estimates Past::estimates(const Segment& latest) const {
  Estimates result = final_;
  if (!options_.recalls) {
    run_.visit(latest, [&](const SmoothedState& one) { append_estimate(one, result); });
    return result;
  }
  std::vector<Stretch> stretches = recorded();
  stretches.push_back({&latest, &revived_});
  for (const SmoothedState& one : smooth_segments(stretches)) append_estimate(one, result);
  return result;
}

std::vector<Stretch> Past::recorded() const {
  std::vector<Stretch> stretches;
  for (const auto& record : records_) stretches.push_back({&record->segment, &record->revived});
  return stretches;
}

void Past::append_estimate(const SmoothedState& one, Estimates& estimates) const {
  std::visit(
      Overloaded{[&](const PastLandmark& past) {
                   if (past.has_returned) return;
                   const Landmark& landmark = past.landmark;
                   estimates.landmarks.push_back({.id = landmark.id,
                                                  .p_world = landmark.p_world + one.correction,
                                                  .covariance = one.covariance,
                                                  .observations = landmark.observations});
                 },
                 [&](const LeftPose& pose) {
                   estimates.poses.push_back(
                       corrected({.time = pose.time, .map_T_imu = pose.map_T_imu}, one.correction,
                                 one.covariance));
                 },
                 [&](const PriorMap& map) { append_prior(one, map, estimates); }},
      states_[static_cast<std::size_t>(one.number)]);
}

// The landmarks of a prior map that have never returned.
void Past::append_prior(const SmoothedState& shared, const PriorMap& map,
                        Estimates& estimates) const {
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const int number = shared.number + 1 + static_cast<int>(i);
    if (!frame_of(number)) continue;
    const DerivedItem derived = derived_item(shared.number, number);
    const Landmark& landmark = map.landmarks[i];
    const MatrixXd& A = derived.by_source;
    estimates.landmarks.push_back(
        {.id = landmark.id,
         .p_world = landmark.p_world + A * shared.correction,
         .covariance = A * shared.covariance * A.transpose() + derived.own,
         .observations = landmark.observations});
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
    const Recorded& older = **record;
    states += older.segment.items.size();
    recorded_bytes_ -= older.segment.bytes();
    if (!options_.recalls) continue;
    if (!older.revived.empty()) landmarks.revive(older.revived);
    returned.insert(older.revived.begin(), older.revived.end());
    landmarks.append(of_recalled(older.segment), keeps);
  }
  smoothed.resize(states);
  if (options_.recalls) {
    std::erase_if(smoothed, [&](const SmoothedState& s) {
      return may_return(s.number) || is_frame(s.number);
    });
  }
  for (const SmoothedState& one : smoothed) append_estimate(one, final_);
  records_.erase(records_.begin(), middle);
  if (!options_.recalls) return;
  records_.insert(records_.begin(), std::make_shared<Recorded>(Recorded{
                                        .segment = landmarks.composed(keeps), .revived = {}}));
  recorded_bytes_ += records_.front()->segment.bytes();
}

std::size_t Past::bytes() const { return recorded_bytes_ + chain_.bytes() + run_.bytes(); }

}  // namespace chasles
