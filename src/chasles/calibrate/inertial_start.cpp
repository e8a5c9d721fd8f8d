#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_start_detail.hpp>
#include <chasles/imu/imu_buffer.hpp>

namespace chasles::calibrate_detail {
namespace {

using Eigen::Vector3d;

constexpr double kMostUnexplained = 0.3;  // of the rates, for a first alignment
constexpr double kMostForce = 0.2;        // relative error of its mean

std::vector<SeenAttitude> attitudes_of_first_camera(const CamerasCalibration& alone) {
  std::vector<SeenAttitude> attitudes;
  for (const ExplainedView& one : alone.views) {
    const Camera& camera = alone.cameras[static_cast<std::size_t>(one.view.camera)];
    if (!attitudes.empty() && attitudes.back().time == one.view.time) continue;
    attitudes.push_back({one.view.time, camera.cam_T_imu.R.transpose() * one.cam_T_target.R});
  }
  return attitudes;
}

// Whether axes of the other handedness explain the rates far better.
bool is_mirrored(const RotationAlignment& alignment, const std::vector<SeenAttitude>& attitudes,
                 std::vector<ImuSample> imu) {
  constexpr double kExplained = 0.02, kFarBetter = 0.2;  // parts: of the rates, of what was left
  if (alignment.unexplained < kExplained) return false;
  for (ImuSample& sample : imu) sample.angular_rate_imu = -sample.angular_rate_imu;
  const auto mirrored = align_rotations(attitudes, imu);
  return mirrored && mirrored->unexplained < kFarBetter * alignment.unexplained;
}

// Samples of [first, last].
struct SampledTime {
  Time first, last;
};

std::vector<SampledTime> sampled_times(const InertialCalibrationInput& input) {
  std::vector<SampledTime> times;
  std::size_t recording = 0;
  for (const ImuSample& sample : input.imu) {
    if (times.empty() || input.recording_of(sample.time) != recording) {
      recording = input.recording_of(sample.time);
      times.resize(recording + 1, {sample.time, sample.time});
    }
    times.back().last = sample.time;
  }
  times.resize(input.recordings());
  return times;
}

// The mean forces, of each recording, in the target's frame. Accelerations are zero in the mean.
std::vector<Vector3d> first_gravity(const InertialCalibrationInput& input,
                                    const std::vector<InertialInstant>& instants,
                                    const std::vector<Vector3d>& forces) {
  std::vector<Vector3d> gravity;
  for (std::size_t r = 0; r < input.recordings(); ++r) {
    Vector3d force = Vector3d::Zero();
    double count = 0;
    for (std::size_t k = 0; k < instants.size(); ++k) {
      if (instants[k].recording != r) continue;
      force += forces[k];
      ++count;
    }
    if (count == 0) {
      throw InputError(fmt::format(
          "recording {} of {}: the IMU covers none of its views: expected both by one clock, as in "
          "the first recording",
          r + 1, input.recordings()));
    }
    const double mean = force.norm() / count;
    if (std::abs(mean / input.gravity - 1) > kMostForce) {
      throw InputError(fmt::format(
          "the mean of the specific force in the target's frame is {:.3g} m/s^2, expected about "
          "{:.3g}: are the samples in m/s^2, with gravity, and in the axes of the gyroscope?",
          mean, input.gravity));
    }
    gravity.push_back(-input.gravity * force.normalized());
  }
  return gravity;
}

// Forces against the accelerations of the cameras: s in s f = a - g, with its standard deviation.
struct ForceScale {
  double scale = 1, sigma = 0;
};

// Three instants that follow each other give the acceleration of the camera, at R r before the
// IMU's: a least-squares fit of s, r and, of each recording, g. The poses are those of cameras at
// the place of the IMU.
ForceScale force_scale(const std::vector<InertialInstant>& instants,
                       const std::vector<InertialState>& states,
                       const std::vector<Vector3d>& forces, std::size_t recordings) {
  constexpr double kLongestStep = 0.1;  // [s]
  const auto unknowns = static_cast<Eigen::Index>(4 + 3 * recordings);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  double squares = 0, rows = 0;
  for (std::size_t k = 1; k + 1 < instants.size(); ++k) {
    const double h = to_seconds(instants[k].time - instants[k - 1].time);
    const double next = to_seconds(instants[k + 1].time - instants[k].time);
    if (!(h > 0 && next > 0) || h > kLongestStep || next > kLongestStep) continue;
    const double t = (h + next) / 2;
    const SE3 &a = states[k - 1].world_T_imu, &b = states[k].world_T_imu,
              &c = states[k + 1].world_T_imu;
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, unknowns);
    J.col(0) = t * forces[k];
    J.middleCols<3>(1) = (c.R - b.R) / next - (b.R - a.R) / h;
    const auto gravity = static_cast<Eigen::Index>(4 + 3 * instants[k].recording);
    J.middleCols<3>(gravity) = t * Eigen::Matrix3d::Identity();
    const Vector3d change = (c.p - b.p) / next - (b.p - a.p) / h;
    normal += J.transpose() * J;
    right += J.transpose() * change;
    squares += change.squaredNorm();
    rows += 3;
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
  const Eigen::VectorXd x = factor.solve(right);
  const double left = std::max(0.0, squares - x.dot(right));
  const Eigen::VectorXd column = factor.solve(Eigen::VectorXd::Unit(unknowns, 0));
  return {.scale = x[0],
          .sigma = std::sqrt(left / std::max(1.0, rows - static_cast<double>(unknowns)) *
                             std::max(0.0, column[0]))};
}

}  // namespace

RotationAlignment aligned(const InertialCalibrationInput& input, const CamerasCalibration& alone) {
  const std::vector<SeenAttitude> attitudes = attitudes_of_first_camera(alone);
  const auto alignment = align_rotations(attitudes, input.imu);
  if (!alignment) {
    throw InputError(
        "the IMU and the views of the target have too little time in common: expected views in "
        "quick succession, at most 0.25 s apart (`--every`), by a clock within 1 s of the IMU's, "
        "and at least 10 of them");
  }
  if (is_mirrored(*alignment, attitudes, input.imu)) {
    throw InputError(
        "the gyroscope turns the other way round than the cameras: expected right-handed axes and "
        "rates: change the sign of all its axes, or of the one that is wrong");
  }
  if (alignment->unexplained <= kMostUnexplained) return *alignment;
  throw InputError(fmt::format(
      "the gyroscope does not turn as the cameras do: {:.0f} % of their rates are unexplained, "
      "expected less than {:.0f} %: was the target static, is the motion brisk, and are units "
      "and clocks of the IMU right (`chasles check`)?",
      100 * alignment->unexplained, 100 * kMostUnexplained));
}

std::vector<InertialInstant> inertial_instants(const std::vector<ExplainedView>& views,
                                               const InertialCalibrationInput& input,
                                               double offset) {
  constexpr double kMargin = 0.1;  // [s]
  const std::vector<SampledTime> sampled = sampled_times(input);
  std::vector<InertialInstant> instants;
  const Time shift(static_cast<std::int64_t>(std::llround(1e9 * offset)));
  for (const ExplainedView& one : views) {
    const Time time = one.view.time + shift;
    const std::size_t recording = input.recording_of(time);
    if (to_seconds(time - sampled[recording].first) < kMargin ||
        to_seconds(sampled[recording].last - time) < kMargin) {
      continue;
    }
    if (instants.empty() || instants.back().time != time) {
      instants.push_back({.time = time, .views = {}, .recording = recording, .sample = {}});
    }
    instants.back().views.push_back(&one.view);
  }
  return instants;
}

InertialRig first_rig(const InertialCalibrationInput& input, const CamerasCalibration& alone,
                      const RotationAlignment& alignment,
                      const std::vector<InertialInstant>& instants) {
  InertialRig x{.cameras = alone.cameras,
                .offsets = std::vector<double>(alone.cameras.size(), alignment.time_offset),
                .gravity = {},
                .imu = {},
                .shape = alone.shape,
                .states = {}};
  x.imu.has_g_sensitivity = false;
  x.imu.has_scale = x.imu.has_misalignment = input.has_imu_errors;
  SE3 cam0_T_imu;  // its position follows
  cam0_T_imu.R = alignment.cam_R_imu;
  for (Camera& camera : x.cameras) {
    camera.cam_T_imu = camera.cam_T_imu * cam0_T_imu;
    if (input.has_readout) camera.shutter.readout = std::max(camera.shutter.readout, 0.001);
  }
  std::map<std::pair<Time, int>, SE3> poses;
  for (const ExplainedView& one : alone.views) {
    poses[{one.view.time, one.view.camera}] = one.cam_T_target;
  }
  ImuBuffer buffer({.convention = input.convention});
  for (const ImuSample& sample : input.imu) buffer.add(sample);
  std::vector<Vector3d> forces;  // in the target's frame
  for (const InertialInstant& instant : instants) {
    const TargetView& view = *instant.views.front();
    const SE3 cam_T_target = poses.at({view.time, view.camera});
    InertialState state;
    state.world_T_imu =
        cam_T_target.inverse() * x.cameras[static_cast<std::size_t>(view.camera)].cam_T_imu;
    state.gyroscope_bias = alignment.gyroscope_bias;
    x.states.push_back(state);
    forces.push_back(state.world_T_imu.R * buffer.at(instant.time)->specific_force_imu);
  }
  x.gravity = first_gravity(input, instants, forces);
  const ForceScale force = force_scale(instants, x.states, forces, input.recordings());
  if (force.scale < -3 * force.sigma) {
    throw InputError(fmt::format(
        "the accelerometer has the other sign: its changes are {:.2f} times those of the cameras' "
        "motion, expected about 1: change the signs of its axes, so that in a standstill the one "
        "that points up measures +{:.3g} m/s^2",
        force.scale, input.gravity));
  }
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    const std::size_t a = k > 0 ? k - 1 : k, b = k + 1 < x.states.size() ? k + 1 : k;
    const double t = to_seconds(instants[b].time - instants[a].time);
    if (t > 0 && t < kLongestLink) {
      x.states[k].v_world = (x.states[b].world_T_imu.p - x.states[a].world_T_imu.p) / t;
    }
  }
  return x;
}

}  // namespace chasles::calibrate_detail
