#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/channels.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/image_messages.hpp>
#include <chasles/viewers/map_messages.hpp>
#include <chasles/viewers/placement.hpp>
#include <chasles/viewers/pose_messages.hpp>
#include <chasles/viewers/recognition_messages.hpp>
#include <chasles/viewers/run_mcap.hpp>
#include <chasles/viewers/state_messages.hpp>
#include <chasles/viewers/topics.hpp>
#include <chasles/viewers/way_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

// A message unless it is null.
void add(const ViewerTopic& topic, Time time, const Json& message, Channels& out) {
  if (!message.is_null()) out.add(topic, time, message);
}

void add_poses(const Run& run, Channels& out) {
  for (const RunState& s : run.states) {
    add(kTfTopic, s.time, tf_message(s), out);
    add(kPoseTopic, s.time, pose_message(s), out);
    add(kOdometryTopic, s.time, odometry_message(s), out);
  }
}

void add_truth(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!errors.problem.empty()) return;
  for (std::size_t i = 0; i < errors.matched.truth.size(); ++i) {
    const Time time = run.states[errors.matched.estimate_index[i]].time;
    out.add(kTruthTopic, time,
            pose_in_world(time, errors.world_T_truth_first * errors.matched.truth[i].pose));
  }
}

void add_ways(const Run& run, const AgainstTruth& errors, Time first, Channels& out) {
  Json entities = Json::array({way("estimate", finite_poses(run), {}, kEstimateColour, first)});
  if (!run.truth.empty() && errors.problem.empty()) {
    entities.push_back(way("truth", run.truth, errors.world_T_truth_first, kTruthColour, first));
  }
  if (!run.dead_reckoning.empty()) {
    entities.push_back(way("dead reckoning", run.dead_reckoning, {}, kDeadReckoningColour, first));
  }
  out.add(kWaysTopic, first, {{"entities", std::move(entities)}});
}

void add_places(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!run.georeference || !errors.problem.empty()) return;
  const SE3 placed = truth_T_world(run);
  for (const RunState& s : run.states) {
    add(kLocationTopic, s.time, location_message(s, placed, *run.georeference), out);
  }
}

Json parsed(const ReportRun& run) {
  if (run.summary.empty()) return Json::object();
  Json summary = Json::parse(run.summary, nullptr, false);
  if (summary.is_object()) return summary;
  throw InputError(fmt::format("the summary of run '{}' is not a json object", run.run.name));
}

PoseError nees_coordinates(const Json& summary) {
  const auto chart = summary.find("chart");
  const bool known = chart != summary.end() && chart->is_string();
  return known ? pose_error_of(chart->get<std::string>()) : PoseError::kStandard;
}

}  // namespace

std::string run_mcap(const ReportRun& report_run, const std::string& version) {
  const Run& run = report_run.run;
  const Json summary = parsed(report_run);
  Channels out("chasles " + version, foxglove_schemas());
  if (!run.states.empty()) {
    const Time first = run.states.front().time;
    const AgainstTruth errors = against_truth(run, nees_coordinates(summary));
    add_poses(run, out);
    add(kTfCamerasTopic, first, cameras_message(summary, first), out);
    add_states(run, out);
    add_errors(run, errors, out);
    add_truth(run, errors, out);
    add_ways(run, errors, first, out);
    out.add(kMapTopic, first, map_cloud(run.landmarks, first));
    out.add(kEllipsoidsTopic, first, map_ellipsoids(run.landmarks, first));
    if (run.prior_map) out.add(kPriorMapTopic, first, prior_map_message(run, first));
    add_map_frame(run, out);
    closure_messages(summary, run, [&out](Time time, const Json& message) {
      out.add(kClosuresTopic, time, message);
    });
    add_places(run, errors, out);
    add_images(run.images, out);
  }
  return mcap_bytes(out.file());
}

}  // namespace chasles
