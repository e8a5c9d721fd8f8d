#include <algorithm>
#include <cmath>
#include <iterator>

#include <chasles/base/error.hpp>
#include <chasles/slam/inertial_slam.hpp>

// Propagation of the filter between images, on the clocks of cameras and IMU.
namespace chasles {
namespace {

// Pixels do not determine a larger time offset [s].
constexpr double kLongestTimeOffset = 0.5;

InertialState inertial_state(const SE3& world_T_imu, const Eigen::Vector3d& v_world,
                             const Eigen::VectorXd& biases) {
  return {.world_T_imu = world_T_imu,
          .v_world = v_world,
          .accelerometer_bias = biases.head<3>(),
          .gyroscope_bias = biases.tail<3>()};
}

}  // namespace

double InertialSlam::time_offset() const {
  return filter_.state().time_offset.value_or(settings_.initial_time_offset());
}

bool InertialSlam::has_sane_clock() const { return std::abs(time_offset()) <= kLongestTimeOffset; }

Time InertialSlam::clock(Time of_cameras) const {
  return has_sane_clock() ? of_cameras + from_seconds(time_offset()) : of_cameras;
}

bool InertialSlam::covers(Time frame) const {
  const bool shifted = filter_.state().time_offset || settings_.initial_time_offset() != 0;
  return !shifted || (imu_.latest() && clock(frame) <= *imu_.latest());
}

void InertialSlam::advance_to(Time time) {
  if (time < now_) {
    throw InputError("time runs backwards: " + std::to_string(time.count()) + " ns after " +
                     std::to_string(now_.count()) + " ns");
  }
  const bool has_offset = filter_.state().time_offset.has_value();
  if (time > now_ || (has_offset && !at_image_)) filter_.propagate(predict_to(time));
  at_image_ = true;
  note_prediction();
  imu_.drop_before(clock(time) - (has_offset ? from_seconds(kTimeOffsetReach) : Time{}));
  now_ = time;
}

// With an estimated time offset the state is that of an image, whatever its time on the IMU's
// clock: it moves to images alone, and the measurements apply at the frame.
void InertialSlam::apply_timed(Time frame) {
  const Time until = clock(frame), offset = until - frame, started = now_;
  std::ranges::stable_sort(timed_, {}, &TimedMeasurement::time);
  const auto later = std::ranges::upper_bound(timed_, until, {}, &TimedMeasurement::time);
  const std::vector<TimedMeasurement> due(std::make_move_iterator(timed_.begin()),
                                          std::make_move_iterator(later));
  timed_.erase(timed_.begin(), later);  // even if a model throws
  for (const TimedMeasurement& one : due) {
    const Time time = one.time - offset;
    if (time < started) {
      ++timed_counts_.late;
      continue;
    }
    advance_to(filter_.state().time_offset ? frame : time);
    Measurement measurement = one.model(filter_.state());
    const auto dof = static_cast<int>(measurement.residual.size());
    if (!std::isfinite(measurement.gate)) measurement.gate = gate_square(dof);
    const UpdateReport& report = filter_.update({&measurement, 1});
    ++(!report.failed && report.accepted.front() ? timed_counts_.used : timed_counts_.rejected);
  }
}

const Prediction& InertialSlam::predict_to(Time time) {
  const State& x = filter_.state();
  std::vector<ImuInterval>& intervals = work_.intervals;
  imu_.between(clock(now_), clock(time), intervals);
  if (time > now_ && intervals.empty()) {
    throw InputError("no IMU sample before the frame at " + std::to_string(time.count()) + " ns");
  }
  Prediction& next = work_.prediction;
  predict(model_, x, intervals, next);
  if (settings_.first_estimates) {
    use_first_estimates(model_, x, to_seconds(time - now_), predicted_, next);
  }
  if (x.time_offset) {
    // The start is the state at a time of the IMU's clock, which does not depend on the offset.
    const Vector9d before =
        at_image_ ? rate_at(inertial_state(x.world_T_imu, *x.v_world, x.additive), clock(now_))
                  : Vector9d::Zero();
    const Vector9d after =
        rate_at(inertial_state(next.world_T_imu, *next.v_world, x.additive), clock(time));
    shift_with_time_offset(x, before, after, next);
  }
  return next;
}

Vector9d InertialSlam::rate_at(const InertialState& state, Time of_imu) const {
  const auto sample = imu_.at(of_imu);
  if (!sample) return Vector9d::Zero();
  return motion_rate(state, gravity_world(model_, filter_.state()), *sample);
}

// At the time e.time.
NavState InertialSlam::motion() {
  const State& x = filter_.state();
  if (!x.time_offset) {
    find_nav_derivative(x, work_.nav);
    return nav_state(filter_, work_.nav);
  }
  const auto now = inertial_state(x.world_T_imu, *x.v_world, x.additive);
  return nav_state_by_clock(filter_, rate_at(now, clock(now_)), work_.nav);
}

void InertialSlam::note_prediction() {
  predicted_ = {.p_world = filter_.state().world_T_imu.p, .v_world = *filter_.state().v_world};
}

void InertialSlam::compose_when_due() {
  if (settings_.composition_interval <= 0) return;
  if (to_seconds(now_ - composed_) < settings_.composition_interval) return;
  filter_.compose();
  composed_ = now_;
  note_prediction();
}

}  // namespace chasles
