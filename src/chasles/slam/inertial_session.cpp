#include <algorithm>
#include <chrono>
#include <utility>

#include <chasles/base/validate.hpp>
#include <chasles/estimate/plausible.hpp>
#include <chasles/filter/readout.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/inertial_session.hpp>

namespace chasles {
namespace {

// The filter is lost when so many more frames contradict it than agree with it.
constexpr int kContradictions = 40;
constexpr int kMostContradictions = 2;  // as many already degrade it
// A speed that no person, car or drone reaches [m/s].
constexpr double kImpossibleSpeed = 150;
// Between frames that keep their images until the start.
constexpr Time kImageInterval = std::chrono::milliseconds(100);

// A frame that the filter will take after the start. In a map it finds its place then, with the
// images so far.
FeatureFrame kept(const FeatureFrame& frame, const std::deque<FeatureFrame>& before, bool in_map) {
  const auto last = std::find_if(before.rbegin(), before.rend(),
                                 [](const FeatureFrame& f) { return f.images != nullptr; });
  const bool due = last == before.rend() || frame.time - last->time >= kImageInterval;
  return in_map && due ? frame : without_images(frame);
}

SlamReport report_of(const InertialSlam& slam) {
  return {.imu = slam.propagator().imu_counts(),
          .timed = slam.propagator().timed_counts(),
          .places = slam.loops().place_counts(),
          .closures = slam.loops().closures(),
          .recognised = slam.loops().recognised(),
          .known_as = slam.loops().known_as()};
}

}  // namespace

InertialSession::InertialSession(const InertialSlamSettings& filter,
                                 const InitialiserSettings& start, InertialSensors sensors,
                                 std::optional<InertialStart> given,
                                 std::shared_ptr<const LandmarkMap> prior)
    : settings_(validated(filter)),
      start_settings_(start),
      sensors_(std::move(sensors)),
      screen_(sensors_.imu.range()),
      screened_(sensors_.imu.screened),
      given_(std::move(given)),
      prior_(std::move(prior)) {
  sensors_.imu.screened = true;
  end_part(false);
}

std::vector<Estimate> InertialSession::process(const ImuSample& sample) {
  if (screened_) {
    take(sample);
    return take_covered();
  }
  std::vector<Estimate> estimates;
  for (const ImuSample& measured : screen_.add(sample)) {
    take(measured);
    append(take_covered(), estimates);
  }
  return estimates;
}

std::vector<Estimate> InertialSession::take_covered() {
  std::vector<Estimate> estimates;
  while (const auto next = waiting_.next([&](const auto& f) { return covered(f); })) {
    append(take(*next), estimates);
  }
  return estimates;
}

void InertialSession::take(const ImuSample& measured) {
  const bool unknown = gaps_.add(measured.time).has_value();
  if (slam_ && unknown) reset(false);
  if (slam_) {
    slam_->process(measured);
    trial_.process(measured);
    return;
  }
  samples_.add(measured);
  const bool is_calibrated = agreed_ && agreed_->calibration && agreed_->calibration->imu;
  initialiser_->add(is_calibrated
                        ? corrected(*agreed_->calibration->imu, sensors_.imu.range(), measured)
                        : measured);
}

void InertialSession::process(const TimedMeasurement& measurement) {
  if (slam_) {
    slam_->process(measurement);
    trial_.process(measurement);
  } else {
    timed_.push_back(measurement);
  }
}

bool InertialSession::usable(const FeatureFrame& frame) const {
  return (!last_frame_ || frame.time > *last_frame_) && gaps_.last() &&
         frame.time - *gaps_.last() <= kLongestGap;
}

std::vector<Estimate> InertialSession::process(const FeatureFrame& frame) {
  if (!waiting_since_ && !slam_) waiting_since_ = now_ = frame.time;
  if (!usable(frame)) {
    ++earlier_.report.dropped_frames;
    return {};
  }
  now_ = frame.time;
  last_frame_ = frame.time;
  if (waiting_.empty() && covered(frame)) return take(frame);
  waiting_.add(frame);
  return take_covered();
}

std::vector<Estimate> InertialSession::finish() {
  std::vector<Estimate> estimates;
  while (const auto frame = waiting_.next()) append(take(*frame), estimates);
  return estimates;
}

// With the offset of the filter, else the last estimated one, else that of the settings.
Time InertialSession::clock(Time of_cameras) const {
  if (slam_) return slam_->clock(of_cameras);
  double offset = settings_.initial_time_offset();
  if (agreed_ && agreed_->calibration) {
    offset = agreed_->calibration->time_offset.value_or(offset);
  }
  return of_cameras + from_seconds(offset);
}

bool InertialSession::covered(const FeatureFrame& frame) const {
  const double readout = longest_readout(sensors_.cameras);
  const bool waits =
      settings_.has_time_offset() || settings_.initial_time_offset() != 0 || readout > 0;
  return !waits || clock(frame.time) + from_seconds(readout) <= *gaps_.last();
}

std::vector<Estimate> InertialSession::take(const FeatureFrame& frame) {
  if (slam_) {
    const auto estimate = step(frame);
    return estimate ? std::vector{*estimate} : std::vector<Estimate>{};
  }
  if (given_) return wait_for_given(frame);
  frames_.push_back(kept(frame, frames_, map_to_search() != nullptr));
  std::optional<InertialStart> start;
  if (!frame.pixels.empty()) {
    FeatureFrame by_clock = frames_.back();
    by_clock.time = clock(frame.time);
    start = initialiser_->add(by_clock);
  }
  if (start) {
    const auto calibration =
        agreed_ ? agreed_->calibration : stated_calibration(settings_, sensors_.cameras);
    if (calibration) widen_start(*calibration, samples_.all(), *start);
    return begin(agreed_ ? continued(*start, *agreed_)
                         : placed(*start, start_settings_, sensors_.cameras.front()));
  }
  // Data older than any window are not replayed.
  const Time oldest = frame.time - from_seconds(2 * start_settings_.max_window);
  while (frames_.front().time < oldest) frames_.pop_front();
  const Time reach = clock(frames_.front().time) -
                     (settings_.has_time_offset() ? from_seconds(kTimeOffsetReach) : Time{});
  samples_.drop_before(reach);
  earlier_.report.timed.late += static_cast<int>(
      std::erase_if(timed_, [&](const TimedMeasurement& m) { return m.time < reach; }));
  return {};
}

std::vector<Estimate> InertialSession::wait_for_given(const FeatureFrame& frame) {
  if (clock(frame.time) < given_->time) return {};
  const auto start = std::exchange(given_, std::nullopt);
  if (std::ranges::none_of(samples_.all(), [&](const ImuSample& sample) {
        return std::chrono::abs(sample.time - start->time) <= kLongestGap;
      })) {
    ++earlier_.report.resets;
    return {};
  }
  frames_ = {frame};
  return begin(*start);
}

std::vector<Estimate> InertialSession::begin(InertialStart start) {
  slam_ = std::make_unique<InertialSlam>(settings_, sensors_.cameras, sensors_.noise, sensors_.imu,
                                         sensors_.pixel_sigma, start, map_to_search(),
                                         start_settings_.in_map && !agreed_);
  start_ = start;
  initialiser_.reset();
  waiting_since_.reset();
  for (const ImuSample& sample : samples_.all()) slam_->process(sample);
  for (const TimedMeasurement& measurement : std::exchange(timed_, {})) {
    if (measurement.time >= start.time) {
      slam_->process(measurement);
    } else {
      ++earlier_.report.timed.late;
    }
  }
  std::vector<Estimate> estimates;
  for (const FeatureFrame& frame : std::exchange(frames_, {})) {
    if (!slam_ || clock(frame.time) < start.time) continue;
    if (const auto estimate = step(frame)) estimates.push_back(*estimate);
  }
  samples_.clear();
  return estimates;
}

// An estimate that is not finite is replaced by the last finite one.
std::optional<Estimate> InertialSession::step(const FeatureFrame& frame) {
  Estimate e = slam_->process(frame);
  if (const auto without = trial_.assess(frame, slam_)) e = *without;
  if (observer_) observer_(frame, slam_->outcomes());
  // A time offset that decreases, or restarts, does not turn time back.
  if (!first_time_) first_time_ = e.time;
  if (last_time_) e.time = std::max(e.time, *last_time_ + Time(1));
  last_time_ = e.time;
  if (is_credible(e)) {
    if (contradictions_ > kMostContradictions && e.health == Health::kOk) {
      e.health = Health::kDegraded;
      e.degradation = has_unknown_speed(e) ? Degradation::kUnknownSpeed : Degradation::kRejections;
    }
    last_ = e;
    if (contradictions_ == 0) agreed_ = e;
    return e;
  }
  e.health = Health::kLost;
  e.in_map.reset();
  reset(true);
  if (is_finite(e)) return e;
  if (!last_) return std::nullopt;
  e.world_T_imu = last_->world_T_imu;
  e.v_world = last_->v_world;
  e.additive = last_->additive;
  e.covariance = last_->covariance;
  e.calibration = last_->calibration;
  e.nis = e.innovation_products = e.innovation_squares = 0;
  e.nis_dof = 0;
  return e;
}

void InertialSession::reset(bool lost) {
  end_part(lost);
  ++earlier_.report.resets;
}

bool InertialSession::is_credible(const Estimate& e) {
  contradictions_ = std::max(0, contradictions_ + (contradicted(e) ? 1 : -1));
  return e.health != Health::kLost && is_finite(e) && contradictions_ < kContradictions &&
         e.v_world->norm() < kImpossibleSpeed;
}

void InertialSession::end_part(bool lost) {
  if (slam_) {
    earlier_.past = past_nav();
    std::erase_if(earlier_.past.landmarks, [](const MapLandmark& l) {
      return !l.p_world.allFinite() || !l.covariance.allFinite();
    });
    std::erase_if(earlier_.past.poses, [](const PastPose& pose) { return !is_finite(pose); });
    keep_map(lost);
    earlier_.report = report_of_parts();
    earlier_.report.timed.late += slam_->propagator().timed_waiting();
    slam_.reset();
    trial_.end();
  }
  contradictions_ = 0;
  earlier_.report.dropped_frames += static_cast<int>(waiting_.size());
  waiting_.clear();
  initialiser_ = std::make_unique<Initialiser>(
      start_settings_, calibrated(sensors_.cameras, agreed_ ? agreed_->calibration : std::nullopt),
      sensors_.noise, sensors_.imu, sensors_.pixel_sigma);
}

// What a part saw before it was lost may still be recognised.
void InertialSession::keep_map(bool lost) {
  if (settings_.recognise != Recognise::kAppearance) return;
  if (!lost) {
    earlier_.map = landmark_map();
    earlier_.map_placed = has_place();
  }
  if (prior_ || !agreed_ || !slam_->filter().covariance().allFinite()) return;
  const Time agreed = agreed_->time - (slam_->clock(Time{}) - Time{});
  LandmarkMap map = lost ? slam_->landmark_map(agreed) : *earlier_.map;
  const bool finite =
      std::ranges::all_of(map.points, [](const auto& p) { return p.p_map.allFinite(); }) &&
      map.covariance.shared().allFinite();
  if (!finite || (seen_before_ && map.points.size() < seen_before_->points.size())) return;
  map.sessions.back().begin = first_time_.value_or(map.sessions.back().end);
  seen_before_ = std::make_shared<LandmarkMap>(std::move(map));
}

std::shared_ptr<const LandmarkMap> InertialSession::map_to_search() const {
  return prior_ ? prior_ : seen_before_;
}

std::vector<Requirement> InertialSession::requirements() const {
  if (!initialiser_) return {};
  if (!gaps_.last()) return {at_least("IMU samples", 0, 1, "")};
  return initialiser_->requirements();
}

double InertialSession::waited() const {
  return waiting_since_ ? to_seconds(now_ - *waiting_since_) : 0;
}

SlamReport InertialSession::report_of_parts() const {
  SlamReport all = earlier_.report;
  if (slam_) all.merge(report_of(*slam_));
  return all;
}

SlamReport InertialSession::report() const {
  SlamReport all = report_of_parts();
  if (!screened_) all.imu.note(screen_.counts());
  return all;
}

// Whether a part has found its place in the prior map.
bool InertialSession::has_place() const {
  return earlier_.report.places.placed || (slam_ && slam_->loops().place_counts().placed);
}

// The map in which the run has found its place, else the larger one.
std::optional<LandmarkMap> InertialSession::landmark_map() const {
  if (!slam_ || settings_.recognise != Recognise::kAppearance) return earlier_.map;
  const bool placed = slam_->loops().place_counts().placed.has_value();
  if (earlier_.map && earlier_.map_placed && !placed) return earlier_.map;
  LandmarkMap map = slam_->landmark_map();
  const bool smaller = earlier_.map && map.points.size() < earlier_.map->points.size();
  if (smaller && placed == earlier_.map_placed) return earlier_.map;
  map.sessions.back().begin = first_time_.value_or(map.sessions.back().end);
  return map;
}

Eigen::Vector3d InertialSession::gyroscope_bias() const {
  return slam_ && last_ ? Eigen::Vector3d(last_->additive.tail<3>()) : Eigen::Vector3d::Zero();
}

Past::Estimates InertialSession::past_nav() const {
  Past::Estimates past = earlier_.past;
  if (!slam_) return past;
  Past::Estimates own = slam_->past_nav();
  if (!prior_) {  // those of earlier parts are there already
    std::erase_if(own.landmarks, [](const MapLandmark& l) { return l.id >= kFirstMapId; });
  }
  past.landmarks.insert(past.landmarks.end(), own.landmarks.begin(), own.landmarks.end());
  past.poses.insert(past.poses.end(), own.poses.begin(), own.poses.end());
  return past;
}

std::vector<LandmarkId> InertialSession::in_state() const {
  std::vector<LandmarkId> ids;
  if (!slam_) return ids;
  for (const Landmark& l : slam_->filter().state().landmarks) ids.push_back(l.id);
  return ids;
}

}  // namespace chasles
