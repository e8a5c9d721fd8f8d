#include <algorithm>
#include <iterator>

#include <chasles/slam/state_predictor.hpp>

namespace chasles {
namespace {

const Eigen::Vector3d kGravityWorld(0, 0, -kStandardGravity);

// P <- F P F^T + Q, where the biases' rows of F are those of the identity.
void propagate(const StrapdownStep& step, Matrix15d& P) {
  const Eigen::Matrix<double, 9, 15> F = step.F.topRows<9>();
  const Eigen::Matrix<double, 9, 15> FP = F * P;
  const Eigen::Matrix<double, 9, 9> motion = FP * F.transpose();
  P.topLeftCorner<9, 9>() = (motion + motion.transpose()) / 2;
  P.topRightCorner<9, 6>() = FP.rightCols<6>();
  P.bottomLeftCorner<6, 9>() = FP.rightCols<6>().transpose();
  P += step.Q;
}

}  // namespace

void StatePredictor::add(const ImuSample& sample) {
  for (const ImuSample& measured : screen_.add(sample)) {
    imu_.add(measured);
    if (const auto gap = gaps_.add(measured.time)) {
      after_gap_ = gap->next;
      steps_.clear();
    }
  }
  if (!imu_.latest()) return;
  if (!steps_.empty() && *imu_.latest() - steps_.front().time > kLongest) steps_.clear();
  if (!steps_.empty() && work_ == Work::kAtOnce) extend();
  // An estimate that comes late is of an older frame.
  if (steps_.empty()) imu_.drop_before(*imu_.latest() - kLongest);
}

void StatePredictor::correct(const Estimate& estimate) {
  steps_.clear();
  if (estimate.health == Health::kLost || (after_gap_ && estimate.time < *after_gap_)) return;
  if (!estimate.v_world || estimate.additive.size() != 6 || estimate.covariance.rows() != 15)
    return;
  const AdditiveStates& biases = estimate.additive;
  correction_ = estimate.calibration ? estimate.calibration->imu : std::nullopt;
  steps_.push_back({.time = estimate.time,
                    .state = {.world_T_imu = estimate.world_T_imu,
                              .v_world = *estimate.v_world,
                              .accelerometer_bias = biases.head<3>(),
                              .gyroscope_bias = biases.tail<3>()},
                    .covariance = estimate.covariance});
  imu_.drop_before(estimate.time);
  if (work_ == Work::kAtOnce) extend();
}

void StatePredictor::find_intervals(Time from, Time to) {
  imu_.between(from, to, intervals_);
  if (!correction_) return;
  for (ImuInterval& interval : intervals_) interval = corrected(*correction_, interval);
}

// From the last step to the last sample, a step for each sample.
void StatePredictor::extend() {
  const std::optional<Time> latest = imu_.latest();
  if (!latest || *latest <= steps_.back().time) return;
  if (*latest - steps_.front().time > kLongest) return steps_.clear();
  const Time from = steps_.back().time;
  find_intervals(from, *latest);
  double since = 0;
  for (std::size_t i = 0; i < intervals_.size(); ++i) {
    since += intervals_[i].tau;
    const bool last = i + 1 == intervals_.size();
    const Step& before = steps_.back();
    const StrapdownStep step = strapdown(before.state, intervals_[i], kGravityWorld, noise_);
    Step after{.time = last ? *latest : from + from_seconds(since),
               .state = step.state,
               .covariance = before.covariance};
    propagate(step, after.covariance);
    steps_.push_back(std::move(after));
  }
}

StatePredictor::Step StatePredictor::moved(Step step, Time to) {
  find_intervals(step.time, to);
  for (const ImuInterval& interval : intervals_) {
    const StrapdownStep next = strapdown(step.state, interval, kGravityWorld, noise_);
    step.state = next.state;
    propagate(next, step.covariance);
  }
  step.time = to;
  return step;
}

std::optional<PredictedState> StatePredictor::at(Time time) {
  if (!steps_.empty()) extend();
  if (steps_.empty() || time < steps_.front().time) return std::nullopt;
  const Time known = std::max(steps_.front().time, imu_.latest().value_or(Time::min()));
  if (time > known + TimeGaps::kLongest || time > steps_.front().time + kLongest) {
    return std::nullopt;
  }
  const auto after = std::ranges::upper_bound(steps_, time, {}, &Step::time);
  const Step step = moved(*std::prev(after), time);
  PredictedState result{.time = time,
                        .since_estimate = time - steps_.front().time,
                        .state = step.state,
                        .covariance = step.covariance};
  if (const auto sample = imu_.at(time)) {
    const ImuSample used = correction_ ? corrected(*correction_, *sample) : *sample;
    result.angular_rate_imu = used.angular_rate_imu - step.state.gyroscope_bias;
  }
  return result;
}

}  // namespace chasles
