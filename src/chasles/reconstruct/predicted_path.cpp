#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/imu/imu_correction.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/reconstruct/predicted_path.hpp>
#include <chasles/slam/imu_in_use.hpp>
#include <chasles/slam/state_predictor.hpp>

namespace chasles {
namespace {

// The columns that a prediction begins with: velocity and biases, which come first.
constexpr std::size_t kMotion = 9;

void check_predictable(const Run& run, const Recording& recording) {
  const auto has = [&](const std::string& name) {
    return std::ranges::find(run.extra_names, name) != run.extra_names.end();
  };
  if (run.extra_names.size() < kMotion || run.extra_names[0] != "velocity_x" ||
      run.extra_names[3] != "accelerometer_bias_x" || run.extra_names[6] != "gyroscope_bias_x") {
    throw InputError(
        fmt::format("run '{}' has no velocities and biases, expected a run with an IMU", run.name));
  }
  if (std::ranges::any_of(ImuCorrection{}.names(), has)) {
    throw InputError(fmt::format(
        "run '{}' has estimated parameters of the IMU, with which its samples would have to be "
        "corrected, expected a run without calibrate_imu",
        run.name));
  }
  if (recording.imu.empty()) {
    throw InputError(
        fmt::format("recording '{}' has no IMU samples, expected that of the run", recording.name));
  }
}

Estimate estimate_of(const RunState& state) {
  const auto values = [](const std::vector<double>& list, std::size_t first, std::size_t count) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(list.data() + first, static_cast<Eigen::Index>(count)));
  };
  Estimate estimate;
  estimate.time = state.time;
  estimate.world_T_imu = state.world_T_imu;
  estimate.v_world = Eigen::Vector3d(values(state.extra, 0, 3));
  estimate.additive = values(state.extra, 3, 6);
  estimate.covariance = MotionCovariance::Zero(15, 15);
  estimate.covariance.topLeftCorner<6, 6>() = state.pose_covariance;
  estimate.covariance.diagonal().tail<9>() = values(state.extra_sigma, 0, kMotion).array().square();
  estimate.health = state.health == "lost" ? Health::kLost : Health::kOk;
  return estimate;
}

RunState predicted_state(const PredictedState& predicted, const RunState& from) {
  RunState state{.time = predicted.time,
                 .world_T_imu = predicted.state.world_T_imu,
                 .pose_covariance = predicted.covariance.topLeftCorner<6, 6>(),
                 .extra = from.extra,
                 .extra_sigma = from.extra_sigma,
                 .health = from.health};
  for (std::size_t k = 0; k < 3; ++k) {
    state.extra[k] = predicted.state.v_world(static_cast<Eigen::Index>(k));
  }
  const Eigen::VectorXd sigmas = predicted.covariance.diagonal().tail<9>().cwiseSqrt();
  for (std::size_t k = 0; k < kMotion; ++k) {
    state.extra_sigma[k] = sigmas(static_cast<Eigen::Index>(k));
  }
  return state;
}

}  // namespace

PredictedPath predicted_path(const Run& run, const Recording& recording,
                             const InertialRunSettings& settings) {
  check_predictable(run, recording);
  const InertialSlamSettings filter = decided(settings, recording).filter;
  const InertialSensors sensors = inertial_sensors(recording);
  StatePredictor predictor(noise_in_use(filter, sensors.noise), imu_in_use(filter, sensors.imu));
  PredictedPath path{.run = run, .without = 0};
  path.run.states.clear();
  std::size_t next = 0;
  for (const ImuSample& sample : recording.imu) {
    predictor.add(sample);
    for (; next < run.states.size() && run.states[next].time <= sample.time; ++next) {
      predictor.correct(estimate_of(run.states[next]));
    }
    if (next == 0 || sample.time > run.states.back().time) continue;
    const auto predicted = predictor.at(sample.time);
    if (predicted) {
      path.run.states.push_back(predicted_state(*predicted, run.states[next - 1]));
    } else {
      ++path.without;
    }
  }
  return path;
}

}  // namespace chasles
