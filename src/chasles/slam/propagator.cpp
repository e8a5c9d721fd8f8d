#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include <chasles/base/error.hpp>
#include <chasles/filter/readout.hpp>
#include <chasles/slam/imu_in_use.hpp>
#include <chasles/slam/propagator.hpp>
#include <chasles/slam/study_hooks.hpp>

namespace chasles {
namespace {

InertialState inertial_state(const SE3& world_T_imu, const Eigen::Vector3d& v_world,
                             const Eigen::VectorXd& biases) {
  return {.world_T_imu = world_T_imu,
          .v_world = v_world,
          .accelerometer_bias = biases.head<3>(),
          .gyroscope_bias = biases.tail<3>()};
}

}  // namespace

Propagator::Propagator(const InertialSlamSettings& settings, const ImuNoise& noise,
                       const ImuBuffer::Options& imu)
    : model_{.noise = noise_in_use(settings, noise), .first_order = first_order_chart(settings)},
      imu_(imu_in_use(settings, imu)) {}

void Propagator::propagate(SlamContext& x, Time frame) {
  if (!timed_.empty()) apply_timed(x, frame);
  advance_to(x, frame);
  note_readout(x);
}

void Propagator::note_readout(SlamContext& x) {
  const Time readout = from_seconds(longest_readout(x.cameras));
  if (readout <= Time{}) return;
  const State& state = x.state();
  imu_.between(x.clock(x.now), x.clock(x.now) + readout, intervals_);
  if (state.imu) {
    for (ImuInterval& interval : intervals_) interval = corrected(*state.imu, interval);
  }
  x.filter.set_readout(
      measured_readout(intervals_, state.additive)
          .motion(state.world_T_imu.R, *state.v_world, gravity_world(model_, state)));
}

bool Propagator::covers(const SlamContext& x, Time frame) const {
  const double readout = longest_readout(x.cameras);
  const bool waits = x.state().time_offset || x.settings.initial_time_offset() != 0 || readout > 0;
  return !waits || (imu_.latest() && x.clock(frame) + from_seconds(readout) <= *imu_.latest());
}

void Propagator::advance_to(SlamContext& x, Time time) {
  if (time < x.now) {
    throw InputError("time runs backwards: " + std::to_string(time.count()) + " ns after " +
                     std::to_string(x.now.count()) + " ns");
  }
  const bool has_offset = x.state().time_offset.has_value();
  if (time > x.now || (has_offset && !at_image_)) x.filter.propagate(predict_to(x, time));
  at_image_ = true;
  note_prediction(x.state());
  imu_.drop_before(x.clock(time) - (has_offset ? from_seconds(kTimeOffsetReach) : Time{}));
  x.now = time;
}

// With an estimated time offset the state is that of an image, whatever its time on the IMU's
// clock: it moves to images alone, and the measurements apply at the frame.
void Propagator::apply_timed(SlamContext& x, Time frame) {
  const Time until = x.clock(frame), offset = until - frame, started = x.now;
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
    advance_to(x, x.state().time_offset ? frame : time);
    Measurement measurement = one.model(x.state());
    const auto dof = static_cast<int>(measurement.residual.size());
    if (!std::isfinite(measurement.gate)) measurement.gate = x.gate_square(dof);
    const UpdateReport& report = x.filter.update({&measurement, 1});
    ++(!report.failed && report.accepted.front() ? timed_counts_.used : timed_counts_.rejected);
  }
}

const Prediction& Propagator::predict_to(const SlamContext& x, Time time) {
  const State& state = x.state();
  imu_.between(x.clock(x.now), x.clock(time), intervals_);
  if (time > x.now && intervals_.empty()) {
    throw InputError("no IMU sample before the frame at " + std::to_string(time.count()) + " ns");
  }
  Prediction& next = prediction_;
  predict(model_, state, intervals_, next);
  if (x.settings.uses_first_estimates()) {
    use_first_estimates(model_, state, to_seconds(time - x.now), predicted_, next);
  }
  if (state.time_offset) {
    // The start is the state at a time of the IMU's clock, which does not depend on the offset.
    const Vector9d before =
        at_image_ ? rate_at(inertial_state(state.world_T_imu, *state.v_world, state.additive),
                            state, x.clock(x.now))
                  : Vector9d::Zero();
    const Vector9d after = rate_at(inertial_state(next.world_T_imu, *next.v_world, state.additive),
                                   state, x.clock(time));
    shift_with_time_offset(state, before, after, next);
  }
  return next;
}

Vector9d Propagator::rate_at(const InertialState& state, const State& x, Time of_imu) const {
  const auto sample = imu_.at(of_imu);
  if (!sample) return Vector9d::Zero();
  return motion_rate(state, gravity_world(model_, x), x.imu ? corrected(*x.imu, *sample) : *sample);
}

NavState Propagator::motion(const SlamContext& x) {
  const State& state = x.state();
  if (!state.time_offset) {
    find_nav_derivative(state, nav_);
    return nav_state(x.filter, nav_);
  }
  const auto now = inertial_state(state.world_T_imu, *state.v_world, state.additive);
  return nav_state_by_clock(x.filter, rate_at(now, state, x.clock(x.now)), nav_);
}

void Propagator::note_prediction(const State& x) {
  predicted_ = {.p_world = x.world_T_imu.p, .v_world = *x.v_world};
}

}  // namespace chasles
