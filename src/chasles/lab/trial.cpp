#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/base/overloaded.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/eval/ate.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/slam/waiting_frames.hpp>

namespace chasles {
namespace {

void require(const Recording& recording, bool present, const char* what) {
  if (!present) throw InputError("recording '" + recording.name + "' has no " + what);
}

// A mean without NaN entries; NaN without any entry.
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

void set_errors(const SE3& truth, const SE3& pose, const Matrix6d& covariance,
                PoseError coordinates, TrialPoint& point) {
  const PoseNees nees = pose_nees(coordinates, truth, pose, covariance);
  point.position_error = (truth.p - pose.p).norm();
  point.attitude_error = so3::log(truth.R * pose.R.transpose()).norm();
  point.nees_position = nees.position;
  point.nees_attitude = nees.attitude;
  point.nees_pose = nees.pose;
}

TrialPoint point_of(const Estimate& e, const std::optional<SE3>& truth, PoseError coordinates) {
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
  if (truth) set_errors(*truth, e.world_T_imu, e.pose_covariance(), coordinates, point);
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

// The frames, each when the samples reach its time by the filter's own clock.
class CoveredFrames {
 public:
  explicit CoveredFrames(const Recording& recording) : events_(recording) {}

  std::optional<FeatureFrame> next(InertialSlam& slam) {
    const auto covered = [&](const FeatureFrame& frame) { return slam.covers(frame.time); };
    for (;;) {
      if (auto frame = waiting_.next(covered)) return frame;
      auto event = events_.next();
      if (!event) return waiting_.next();
      std::visit(Overloaded{[&](ImuSample&& sample) { slam.process(sample); },
                            [&](FeatureFrame&& frame) { waiting_.add(std::move(frame)); },
                            [](auto&& /*other*/) {}},
                 std::move(*event));
    }
  }

 private:
  EventStream events_;
  WaitingFrames<FeatureFrame> waiting_;
};

// With too few common poses an alignment is meaningless.
void align_to(const Recording& recording, Trial& trial) {
  const auto known = std::ranges::count_if(trial.estimate, [&](const StampedPose& pose) {
    return true_pose_at(recording, pose.time).has_value();
  });
  if (trial.diverged || known < 3) return;
  const MatchedTrajectories matched =
      associate(trial.estimate, recording.truth, {.longest_gap = recording.pairing.longest_gap});
  trial.ate = absolute_error(matched, Alignment::kRigid).position_m.rmse;
  const AbsoluteError upright = absolute_error(matched, Alignment::kPositionYaw);
  trial.ate_posyaw = upright.position_m.rmse;
  trial.attitude_posyaw = upright.attitude_deg.rmse * std::numbers::pi / 180;
}

Trial batch_or_diverged(const FilterVariant& filter, const Recording& recording,
                        const InertialStart& start) {
  try {
    if (filter.estimator.is_window()) {
      return run_window_trial(filter, filter.batch, recording, start);
    }
    const std::vector<TimedMotion> initial = filter_motions(filter, recording, start);
    return run_batch_trial(filter, filter.batch, recording, start, initial).trial;
  } catch (const UsageError&) {
    throw;
  } catch (const Error&) {
    return {.filter = filter.name, .diverged = true};
  }
}

}  // namespace

TrialPoint pose_point(double seconds, const SE3& truth, const SE3& pose, const Matrix6d& covariance,
                      PoseError coordinates) {
  TrialPoint point{.seconds = seconds, .nees_state = kNaN};
  set_errors(truth, pose, covariance, coordinates, point);
  return point;
}

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

InertialStart draw_start(const Recording& recording, const InertialSlamSettings& settings,
                         std::uint64_t seed, std::uint64_t run) {
  InertialStart start = true_start(recording);
  const Random random = random_of_run(seed, run);
  const auto draw = [&](std::uint32_t i) { return random.normal(Stream::kStart, 0, i); };
  const Eigen::Vector3d tilt = settings.initial_tilt_sigma * Eigen::Vector3d(draw(0), draw(1), 0);
  start.nav_T_imu.R = so3::exp(-tilt) * start.nav_T_imu.R;
  start.v_nav -= settings.initial_velocity_sigma * Eigen::Vector3d(draw(2), draw(3), draw(4));
  return start;
}

bool add_to_trial(const std::string& chart, const Recording& recording, Time start,
                  const Estimate& e, Trial& trial) {
  TrialPoint point = point_of(e, true_pose_at(recording, e.time), pose_error_of(chart));
  point.seconds = to_seconds(e.time - start);
  point.nees_state = state_nees(chart, recording, e);
  trial.points.push_back(point);
  trial.estimate.push_back({.time = e.time, .pose = e.world_T_imu});
  trial.landmarks = e.landmarks;
  trial.calibration = e.calibration;
  trial.diverged = e.health == Health::kLost || point.position_error >= kDivergedAt;
  return !trial.diverged;
}

void end_trial(const Recording& recording, Trial& trial) { align_to(recording, trial); }

void run_filter(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                const std::function<bool(const Estimate&)>& take,
                const std::function<void(const InertialSlam&)>& done) {
  require(recording, !recording.cameras.empty(), "camera");
  require(recording, !recording.imu.empty(), "IMU samples");
  require(recording, !recording.frames.empty(), "frames");
  InertialSlam slam = slam_for(filter, recording, start);
  CoveredFrames frames(recording);
  while (const auto seen = frames.next(slam)) {
    interruption_point();
    if (slam.clock(seen->time) < start.time) continue;
    if (!take(slam.process(*seen))) break;
  }
  if (done) done(slam);
}

Trial run_trial(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                KeepMap keep_map) {
  require(recording, !recording.truth.empty(), "truth");
  Trial trial{.filter = filter.name};
  const double started = processor_seconds();
  if (!filter.estimator.is_filter()) {
    trial = batch_or_diverged(filter, recording, start);
    trial.seconds_cpu = processor_seconds() - started;
    return trial;
  }
  const auto take = [&](const Estimate& e) {
    return add_to_trial(filter.settings.chart, recording, start.time, e, trial);
  };
  run_filter(filter, recording, start, take, [&](const InertialSlam& slam) {
    trial.seconds_cpu = processor_seconds() - started;
    if (keep_map != KeepMap::kYes) return;
    Past::Estimates past = slam.past_nav();
    trial.map = std::move(past.landmarks);
    for (const PastPose& pose : past.poses) {
      const auto truth = true_pose_at(recording, pose.time);
      if (!truth) continue;
      trial.smoothed.push_back(pose_point(to_seconds(pose.time - start.time), *truth,
                                          pose.map_T_imu, pose.covariance,
                                          pose_error_of(filter.settings.chart)));
    }
  });
  end_trial(recording, trial);
  return trial;
}

}  // namespace chasles
