#include "bridge.hpp"

#include <exception>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/robot/robot_diagnosis.hpp>
#include <chasles/robot/state_stream.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/map_output.hpp>
#include <chasles/session/output_folder.hpp>

#include "inputs.hpp"
#include "network.hpp"
#include "outputs.hpp"

namespace chasles::bridge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kWait = 0.1;  // [s] between two checks of `stop`
// What has come before the end is taken in so many rounds at most: publishers may go on.
constexpr int kRoundsAtEnd = 100;
constexpr double kLull = 0.02;  // [s] without a message, after which all is there
constexpr auto kSilence = std::chrono::seconds(5), kDiagnosticsPeriod = std::chrono::seconds(1);

RobotSetup setup_of(const BridgeOptions& o, SensorCalibration calibration) {
  SettingSources sources = o.settings;
  sources.estimator = estimator_choice(o.estimator, "--estimator");
  RobotSetup setup = o.robot;
  setup.calibration = std::move(calibration);
  setup.settings = inertial_run_settings_from(sources);
  return setup;
}

SensorCalibration calibration_of(const BridgeOptions& o) {
  SensorCalibration calibration = read_sensor_calibration(o.calibration);
  if (calibration.cameras.empty()) {
    throw InputError(fmt::format(
        "{}: has no camera, expected a calibration of cameras and IMU: Kalibr's camera chain with "
        "imu.yaml, or calibration.yaml (docs/ros2.md)",
        o.calibration.string()));
  }
  for (const std::string& remark : calibration.remarks) spdlog::info("{}", remark);
  return calibration;
}

StateStream::Options stream_of(const BridgeOptions& o) {
  return {.base_T_imu = base_T_imu_of(o),
          .rate = o.rate == "samples" ? StateStream::Rate::kSamples : StateStream::Rate::kImages,
          .points_period = o.points_period,
          .jumps = !o.px4.empty()};
}

/// Takes messages until the end.
class Loop {
 public:
  Loop(const BridgeOptions& options, Participant& participant, Inputs& inputs, Outputs& outputs,
       RobotSlam& slam)
      : options_(options),
        participant_(participant),
        inputs_(inputs),
        outputs_(outputs),
        slam_(slam) {}

  void run(const std::function<bool()>& stop) {
    while (!stop() && !is_idle()) {
      participant_.wait(kWait);
      take();
      const Clock::time_point now = Clock::now();
      if (now - begin_ > kSilence) inputs_.warn_of_silence();
      if (now - diagnosed_ < kDiagnosticsPeriod) continue;
      diagnosed_ = now;
      diagnose();
    }
    for (int round = 0; round < kRoundsAtEnd; ++round) {
      participant_.wait(kLull);
      if (inputs_.take() == 0) break;
    }
  }

 private:
  void take() {
    if (inputs_.take() > 0) last_message_ = Clock::now();
  }

  void diagnose() {
    const RobotReport report = slam_.report();
    RobotDiagnosis diagnosis = chasles::diagnose(report, before_);
    before_ = report;
    inputs_.describe(diagnosis);
    outputs_.send(diagnosis);
  }

  bool is_idle() const {
    return options_.idle &&
           Clock::now() - last_message_ > std::chrono::duration<double>(*options_.idle);
  }

  const BridgeOptions& options_;
  Participant& participant_;
  Inputs& inputs_;
  Outputs& outputs_;
  RobotSlam& slam_;
  Clock::time_point begin_ = Clock::now(), diagnosed_ = begin_, last_message_ = begin_;
  RobotReport before_;  // of the last diagnosis
};

void announce(const BridgeOptions& o, const BridgeNetwork& network, const SensorTopics& topics) {
  spdlog::info("domain {}, {}", network.domain,
               network.configuration.empty()
                   ? "network of CYCLONEDDS_URI"
                   : "network " + (o.network.empty() ? "loopback" : o.network));
  std::string cameras;
  for (const std::string& topic : topics.cameras) cameras += " " + topic;
  spdlog::info("IMU: {}{}; cameras:{}", topics.imu,
               topics.accelerometer.empty() ? "" : " and " + topics.accelerometer, cameras);
}

// Finds errors of the outputs before the run.
void prepare_outputs(const BridgeOptions& o) {
  if (!o.robot.output.empty()) prepare_output(o.robot.output);
  if (!o.robot.save_map.empty()) check_map_output(o.robot.save_map);
}

}  // namespace

void run_bridge(const BridgeOptions& o, const std::function<bool()>& stop) {
  check(o);
  const BridgeNetwork network = network_of(o);
  const SensorCalibration calibration = calibration_of(o);
  const SensorTopics topics = topics_of(o, calibration);
  RobotSetup setup = setup_of(o, calibration);
  prepare_outputs(o);
  Participant participant(network.domain, network.configuration);
  Outputs outputs(participant, o);
  StateStream stream(stream_of(o), outputs);
  RobotSlam slam(
      std::move(setup),
      {.on_estimates = [&](std::span<const Estimate> some,
                           VisualInertialSlam& of) { stream.take(some, of); },
       .on_reset = [](const std::string& why) { spdlog::warn("{}: the run begins anew", why); },
       .on_output =
           [](const std::string& sentence, bool written) {
             spdlog::log(written ? spdlog::level::info : spdlog::level::err, "{}", sentence);
           }});
  stream.set_slam(slam);
  Inputs inputs(participant, o, topics, slam,
                [&](Time time, double period) { stream.take_sample(time, period); });
  announce(o, network, topics);
  // Whatever ends the loop, what was estimated is written.
  std::exception_ptr error =
      error_of([&] { Loop(o, participant, inputs, outputs, slam).run(stop); });
  slam.finish();
  const RobotDiagnosis diagnosis = diagnose(slam.report(), {});
  if (!error) error = error_of([&] { outputs.send(diagnosis); });
  if (stream.any()) return slam.write_outputs(error);
  if (error) std::rethrow_exception(error);
  throw Error(ExitCode::kNotInitialised, "no estimate: " + diagnosis.message);
}

}  // namespace chasles::bridge
