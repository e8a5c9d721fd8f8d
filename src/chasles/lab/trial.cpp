#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <variant>

#include <chasles/constants.hpp>
#include <chasles/error.hpp>
#include <chasles/eval/ate.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/processor_time.hpp>
#include <chasles/sim/random.hpp>
#include <chasles/sim/spline.hpp>

namespace chasles {
namespace {

constexpr Time kLongestGap = std::chrono::milliseconds(100);  // of the truth that is bridged
constexpr double kSlopeReach = 0.5;                           // [s] to both sides
constexpr double kSlopeKnots = 0.1;                           // [s]

void require(const Recording& recording, bool present, const char* what) {
  if (!present) throw InputError("recording '" + recording.name + "' has no " + what);
}

// A mean that skips NaN; NaN where nothing is left.
class Mean {
 public:
  void add(double value) {
    if (std::isnan(value)) return;
    sum_ += value;
    ++count_;
  }
  double value() const { return count_ == 0 ? kNaN : sum_ / static_cast<double>(count_); }

 private:
  double sum_ = 0;
  std::size_t count_ = 0;
};

// The velocity at that time by a spline through the true positions around it.
Eigen::Vector3d slope(const Trajectory& truth, Time time) {
  Trajectory near;
  for (const StampedPose& pose : truth) {
    if (std::abs(to_seconds(pose.time - time)) <= kSlopeReach) near.push_back(pose);
  }
  const Spline spline = fit_spline(near, kSlopeKnots);
  return motion_at(spline, to_seconds(time - spline.start)).v_world;
}

Eigen::Vector3d true_velocity(const Recording& recording, Time time) {
  const auto known = std::ranges::find(recording.true_motion, time, &TrueMotion::time);
  return known != recording.true_motion.end() ? known->v_world : slope(recording.truth, time);
}

std::vector<Time> frame_times(const Recording& recording) {
  std::vector<Time> times;
  for (const FeatureFrame& frame : recording.frames) times.push_back(frame.time);
  for (std::size_t i = 0; recording.images && i < recording.images->size(); ++i) {
    times.push_back(recording.images->time(i));
  }
  return times;
}

TrialPoint point_of(const InertialEstimate& e, const std::optional<SE3>& truth,
                    PoseError coordinates) {
  TrialPoint point{.position_error = kNaN,
                   .attitude_error = kNaN,
                   .nees_position = kNaN,
                   .nees_attitude = kNaN,
                   .nees_pose = kNaN,
                   .nees_state = kNaN,
                   .nis = e.nis,
                   .nis_dof = e.nis_dof,
                   .innovation_products = e.innovation_products,
                   .innovation_squares = e.innovation_squares};
  if (!truth) return point;
  const SE3& pose = e.motion.nav_T_imu;
  const PoseNees nees =
      pose_nees(coordinates, *truth, pose, e.motion.covariance.topLeftCorner<6, 6>());
  point.position_error = (truth->p - pose.p).norm();
  point.attitude_error = so3::log(truth->R * pose.R.transpose()).norm();
  point.nees_position = nees.position;
  point.nees_attitude = nees.attitude;
  point.nees_pose = nees.pose;
  return point;
}

InertialSlam slam_for(const FilterVariant& filter, const Recording& recording,
                      const InertialStart& start) {
  const double pixel_sigma =
      filter.settings.pixel_sigma.value_or(recording.single_pixel_sigma.value_or(1));
  return {filter.settings,
          recording.cameras,
          recording.imu_noise.value_or(ImuNoise{}),
          {.convention = recording.imu_convention},
          pixel_sigma,
          start};
}

// The frames, each when the samples reach up to it by the filter's own clock.
class FramesInTime {
 public:
  explicit FramesInTime(const Recording& recording) : events_(recording) {}

  std::optional<FeatureFrame> next(InertialSlam& slam) {
    while (waiting_.empty() || !slam.covers(waiting_.front().time)) {
      auto event = events_.next();
      if (!event) break;
      if (const auto* sample = std::get_if<ImuSample>(&*event)) slam.process(*sample);
      if (auto* frame = std::get_if<FeatureFrame>(&*event)) waiting_.push_back(std::move(*frame));
    }
    if (waiting_.empty()) return std::nullopt;
    FeatureFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    return frame;
  }

 private:
  EventStream events_;
  std::deque<FeatureFrame> waiting_;
};

// With too little in common an alignment means nothing.
void align_to(const Trajectory& truth, Trial& trial) {
  Trajectory own;
  for (const StampedPose& pose : trial.estimate) {
    if (const auto known = truth_at(truth, pose.time)) own.push_back({pose.time, *known});
  }
  if (trial.diverged || own.size() < 3) return;
  const MatchedTrajectories matched = associate(trial.estimate, own, Time{0});
  trial.ate = absolute_error(matched, Alignment::kRigid).position_m.rmse;
  const AbsoluteError upright = absolute_error(matched, Alignment::kPositionYaw);
  trial.ate_posyaw = upright.position_m.rmse;
  trial.attitude_posyaw = upright.attitude_deg.rmse * std::numbers::pi / 180;
}

Trial batch_or_diverged(const FilterVariant& filter, const Recording& recording,
                        const InertialStart& start) {
  try {
    if (filter.window > 0) return run_window_trial(filter, *filter.batch, recording, start);
    const std::vector<TimedMotion> initial = filter_motions(filter, recording, start);
    return run_batch_trial(filter, *filter.batch, recording, start, initial).trial;
  } catch (const UsageError&) {
    throw;
  } catch (const Error&) {
    return {.filter = filter.name, .diverged = true};
  }
}

}  // namespace

TrialAverages averages(const Trial& trial) {
  Mean position, attitude, square, nees_position, nees_attitude, nees_pose, nees_state;
  double nis = 0, dof = 0, products = 0, squares = 0;
  for (const TrialPoint& point : trial.points) {
    position.add(point.position_error);
    square.add(point.position_error * point.position_error);
    attitude.add(point.attitude_error);
    nees_position.add(point.nees_position);
    nees_attitude.add(point.nees_attitude);
    nees_pose.add(point.nees_pose);
    nees_state.add(point.nees_state);
    nis += point.nis;
    dof += point.nis_dof;
    products += point.innovation_products;
    squares += point.innovation_squares;
  }
  return {.position_error = position.value(),
          .attitude_error = attitude.value(),
          .position_rms = std::sqrt(square.value()),
          .ate = trial.ate,
          .ate_posyaw = trial.ate_posyaw,
          .attitude_posyaw = trial.attitude_posyaw,
          .nees_position = nees_position.value(),
          .nees_attitude = nees_attitude.value(),
          .nees_pose = nees_pose.value(),
          .nees_state = nees_state.value(),
          .nis_per_dof = dof > 0 ? nis / dof : kNaN,
          .innovation_correlation = squares > 0 ? products / squares : kNaN,
          .landmarks = static_cast<double>(trial.landmarks)};
}

double state_nees(const std::string& chart, const Recording& recording, Time time,
                  const NavState& motion) {
  const auto known = std::ranges::lower_bound(recording.true_motion, time, {}, &TrueMotion::time);
  const auto pose = truth_at(recording.truth, time);
  if (known == recording.true_motion.end() || known->time != time || !pose) return kNaN;
  State truth{.world_T_imu = *pose, .v_world = known->v_world, .additive = Eigen::VectorXd(6)};
  truth.additive << known->accelerometer_bias, known->gyroscope_bias;
  const State estimate{
      .world_T_imu = motion.nav_T_imu, .v_world = motion.v_nav, .additive = motion.biases};
  const ErrorChart& coordinates = error_chart(chart);
  Eigen::MatrixXd P = motion.covariance;
  for (int side = 0; side < 2; ++side) {
    push(coordinates, estimate, P);
    P.transposeInPlace();
  }
  return normalised_square(local(coordinates, estimate, truth), P);
}

std::optional<SE3> truth_at(const Trajectory& truth, Time time) {
  const auto next = std::ranges::lower_bound(truth, time, {}, &StampedPose::time);
  if (next == truth.end()) return std::nullopt;
  if (next->time == time) return next->pose;
  if (next == truth.begin()) return std::nullopt;
  const StampedPose& before = *std::prev(next);
  if (next->time - before.time > kLongestGap) return std::nullopt;
  const double part = to_seconds(time - before.time) / to_seconds(next->time - before.time);
  SE3 pose;
  pose.p = before.pose.p + part * (next->pose.p - before.pose.p);
  pose.R = before.pose.R * so3::exp(part * so3::log(before.pose.R.transpose() * next->pose.R));
  return pose;
}

InertialStart draw_start(const Recording& recording, const InertialSlamSettings& settings,
                         std::uint64_t seed, std::uint64_t run) {
  require(recording, !recording.truth.empty(), "truth");
  const std::vector<Time> times = frame_times(recording);
  const auto first = std::ranges::find_if(
      times, [&](Time time) { return truth_at(recording.truth, time).has_value(); });
  require(recording, first != times.end(), "frame at whose time its truth is known");
  const Random random = random_of_run(seed, run);
  const auto draw = [&](std::uint32_t i) { return random.normal(Stream::kStart, 0, i); };
  const Eigen::Vector3d tilt = settings.initial_tilt_sigma * Eigen::Vector3d(draw(0), draw(1), 0);
  InertialStart start{.time = *first, .nav_T_imu = *truth_at(recording.truth, *first)};
  start.nav_T_imu.R = so3::exp(-tilt) * start.nav_T_imu.R;
  start.v_nav = true_velocity(recording, *first) -
                settings.initial_velocity_sigma * Eigen::Vector3d(draw(2), draw(3), draw(4));
  return start;
}

bool add_to_trial(const std::string& chart, const Recording& recording, Time start,
                  const InertialEstimate& e, Trial& trial) {
  TrialPoint point = point_of(e, truth_at(recording.truth, e.time), pose_error_of(chart));
  point.seconds = to_seconds(e.time - start);
  point.nees_state = state_nees(chart, recording, e.time, e.motion);
  trial.points.push_back(point);
  trial.estimate.push_back({.time = e.time, .pose = e.motion.nav_T_imu});
  trial.landmarks = e.landmarks;
  trial.calibration = e.calibration;
  trial.diverged = e.health == Health::kLost || point.position_error >= kDivergedAt;
  return !trial.diverged;
}

void end_trial(const Recording& recording, Trial& trial) { align_to(recording.truth, trial); }

void run_filter(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                const std::function<bool(const InertialEstimate&)>& take) {
  require(recording, !recording.cameras.empty(), "camera");
  require(recording, !recording.imu.empty(), "IMU samples");
  require(recording, !recording.frames.empty(), "frames");
  InertialSlam slam = slam_for(filter, recording, start);
  FramesInTime frames(recording);
  while (const auto seen = frames.next(slam)) {
    if (slam.clock(seen->time) < start.time) continue;
    if (!take(slam.process(*seen))) break;
  }
}

Trial run_trial(const FilterVariant& filter, const Recording& recording,
                const InertialStart& start) {
  require(recording, !recording.truth.empty(), "truth");
  Trial trial{.filter = filter.name};
  const double started = processor_seconds();
  if (filter.batch) {
    trial = batch_or_diverged(filter, recording, start);
    trial.seconds_cpu = processor_seconds() - started;
    return trial;
  }
  run_filter(filter, recording, start, [&](const InertialEstimate& e) {
    return add_to_trial(filter.settings.chart, recording, start.time, e, trial);
  });
  trial.seconds_cpu = processor_seconds() - started;
  end_trial(recording, trial);
  return trial;
}

}  // namespace chasles
