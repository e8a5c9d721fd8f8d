#include <algorithm>
#include <cmath>
#include <utility>

#include <chasles/lie/so3.hpp>
#include <chasles/slam/inertial_session.hpp>

namespace chasles {
namespace {

// The filter is lost when so many frames in a row refuse most of what they see.
constexpr int kRefusedFrames = 40;
constexpr int kFewObservations = 10;
// A speed that nothing carried by a person, a car or a drone has [m/s].
constexpr double kImpossibleSpeed = 150;

double heading(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); }

void add(const ImuBuffer::Counts& more, ImuBuffer::Counts& sum) {
  sum.used += more.used;
  sum.not_finite += more.not_finite;
  sum.not_later += more.not_later;
  sum.gaps += more.gaps;
  sum.saturated += more.saturated;
  sum.extrapolated += more.extrapolated;
}

}  // namespace

InertialSession::InertialSession(const InertialSlamSettings& filter,
                                 const InitialiserSettings& start, InertialSensors sensors,
                                 std::optional<InertialStart> given)
    : settings_(filter),
      start_settings_(start),
      sensors_(std::move(sensors)),
      given_(std::move(given)) {
  end_part();
}

void InertialSession::process(const ImuSample& sample) {
  if (slam_) {
    slam_->process(sample);
    return;
  }
  samples_.push_back(sample);
  initialiser_->add(sample);
}

std::vector<InertialEstimate> InertialSession::process(const FeatureFrame& frame) {
  now_ = frame.time;
  if (slam_) return {step(frame)};
  if (!waiting_since_) waiting_since_ = frame.time;
  if (given_) {
    if (frame.time < given_->time) return {};
    frames_ = {frame};
    return begin(*std::exchange(given_, std::nullopt));
  }
  frames_.push_back(frame);
  const auto start = initialiser_->add(frame);
  if (start) return begin(continued(*start));
  // What is older than any window can be is not replayed.
  const Time oldest = frame.time - from_seconds(2 * start_settings_.max_window);
  while (frames_.front().time < oldest) frames_.pop_front();
  while (samples_.size() > 2 && samples_[1].time < frames_.front().time) samples_.pop_front();
  return {};
}

std::vector<InertialEstimate> InertialSession::begin(InertialStart start) {
  slam_ = std::make_unique<InertialSlam>(settings_, sensors_.cameras, sensors_.noise, sensors_.imu,
                                         sensors_.pixel_sigma, start);
  initialiser_.reset();
  waiting_since_.reset();
  for (const ImuSample& sample : samples_) slam_->process(sample);
  std::vector<InertialEstimate> estimates;
  for (const FeatureFrame& frame : std::exchange(frames_, {})) {
    if (slam_ && frame.time >= start.time) estimates.push_back(step(frame));
  }
  samples_.clear();
  return estimates;
}

InertialEstimate InertialSession::step(const FeatureFrame& frame) {
  const InertialEstimate e = slam_->process(frame);
  if (believed(e)) {
    last_ = e;
    return e;
  }
  InertialEstimate lost = e;
  lost.health = Health::kLost;
  end_part();
  ++resets_;
  return lost;
}

bool InertialSession::believed(const InertialEstimate& e) {
  const bool refused = e.rejected > e.used && e.rejected + e.used >= kFewObservations;
  refused_frames_ = refused ? refused_frames_ + 1 : 0;
  return e.health != Health::kLost && refused_frames_ < kRefusedFrames &&
         e.motion.v_nav.norm() < kImpossibleSpeed;
}

void InertialSession::end_part() {
  if (slam_) {
    earlier_map_ = map_nav();
    earlier_counts_ = imu_counts();
    slam_.reset();
  }
  refused_frames_ = 0;
  initialiser_ = std::make_unique<Initialiser>(start_settings_, sensors_.cameras, sensors_.noise,
                                               sensors_.imu, sensors_.pixel_sigma);
}

// A start in a nav of its own, moved to where the run was last.
InertialStart InertialSession::continued(InertialStart start) const {
  if (!last_) return start;
  const double gap = to_seconds(start.time - last_->time);
  const NavState& before = last_->motion;
  const Eigen::Matrix3d turn =
      so3::exp(Eigen::Vector3d(0, 0, heading(before.nav_T_imu.R) - heading(start.nav_T_imu.R)));
  start.nav_T_imu.R = turn * start.nav_T_imu.R;
  start.nav_T_imu.p = before.nav_T_imu.p;
  start.v_nav = turn * start.v_nav;
  Matrix15d P = start.covariance.value_or(Matrix15d::Zero());
  for (const int row : {0, 6}) {
    P.middleRows<3>(row) = (turn * P.middleRows<3>(row)).eval();
    P.middleCols<3>(row) = (P.middleCols<3>(row) * turn.transpose()).eval();
  }
  const double way = std::max({1.0, before.v_nav.norm(), start.v_nav.norm()}) * gap;
  P.block<3, 3>(3, 3) = before.covariance.block<3, 3>(3, 3);
  P.block<3, 3>(3, 3).diagonal().array() += way * way;
  P(2, 2) += before.covariance(2, 2) + std::min(gap * gap, M_PI * M_PI);  // 1 rad/s
  start.covariance = P;
  return start;
}

std::vector<Requirement> InertialSession::requirements() const {
  return initialiser_ ? initialiser_->requirements() : std::vector<Requirement>{};
}

double InertialSession::waited() const {
  return waiting_since_ ? to_seconds(now_ - *waiting_since_) : 0;
}

ImuBuffer::Counts InertialSession::imu_counts() const {
  ImuBuffer::Counts counts = earlier_counts_;
  if (slam_) add(slam_->imu_counts(), counts);
  return counts;
}

Eigen::Vector3d InertialSession::gyroscope_bias() const {
  return slam_ && last_ ? Eigen::Vector3d(last_->motion.biases.tail<3>()) : Eigen::Vector3d::Zero();
}

std::vector<MapLandmark> InertialSession::map_nav() const {
  std::vector<MapLandmark> map = earlier_map_;
  if (!slam_) return map;
  const std::vector<MapLandmark> own = slam_->map_nav();
  map.insert(map.end(), own.begin(), own.end());
  return map;
}

}  // namespace chasles
