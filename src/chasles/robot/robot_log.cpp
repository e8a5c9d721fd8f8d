#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/robot/robot_log.hpp>
#include <chasles/run_folder/run.hpp>
#include <chasles/session/calibration_report.hpp>
#include <chasles/session/summary.hpp>

namespace chasles {

RobotLog::RobotLog(Recording sensors, InertialRunSettings settings,
                   const InertialRunSettings& decided_settings, const Estimator& estimator)
    : sensors_(std::move(sensors)),
      settings_(std::move(settings)),
      estimator_(estimator),
      recorder_(
          sensors_, estimator_,
          {.calibration_columns = calibration_columns(decided_settings.filter, sensors_.cameras)}) {
}

void RobotLog::add(std::span<const Estimate> estimates) {
  for (const Estimate& e : estimates) recorder_.on_estimate(e, {});
}

void RobotLog::write(const std::filesystem::path& folder) const {
  RunReport report;
  report.estimator = estimator_.report();
  report.interrupted = true;  // no recording whose rest a check could look at
  RunRecorder so_far = recorder_;
  RecordedRun result = so_far.finish(std::move(report));
  // What the folder of a robot does not have.
  result.run.prior_map.reset();
  result.innovation_correlation.reset();
  nlohmann::ordered_json summary =
      summary_json(result, settings_, inertial_sensors(sensors_), sensors_);
  summary.erase("frontend");  // its totals are of a run by the command
  write_run(result.run, summary, folder);
}

}  // namespace chasles
