#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/channels.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/image_messages.hpp>
#include <chasles/viewers/map_messages.hpp>
#include <chasles/viewers/placement.hpp>
#include <chasles/viewers/recognition_messages.hpp>
#include <chasles/viewers/run_mcap.hpp>
#include <chasles/viewers/state_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

// [theta; dp] has the rotation first; Foxglove has the position first.
std::vector<double> position_first(const Matrix6d& covariance) {
  std::vector<double> rows;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) rows.push_back(covariance((i + 3) % 6, (j + 3) % 6));
  }
  return rows;
}

void add_poses(const Run& run, Channels& out) {
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.p.allFinite() || !s.world_T_imu.R.allFinite()) continue;
    const Json pose = proto_pose(s.world_T_imu);
    out.add(
        "/tf", "foxglove.FrameTransforms", s.time,
        {{"transforms", Json::array({proto_transform(s.time, "world", "imu", s.world_T_imu)})}});
    out.add("/pose", "foxglove.PoseInFrame", s.time,
            {{"timestamp", proto_time(s.time)}, {"frame_id", "world"}, {"pose", pose}});
    out.add("/odometry", "foxglove.Odometry", s.time,
            {{"timestamp", proto_time(s.time)},
             {"frame_id", "world"},
             {"body_frame_id", "imu"},
             {"pose", pose},
             {"pose_covariance", position_first(s.pose_covariance)}});
  }
}

SE3 motion(const Json& rows) {
  SE3 T;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < 3; ++j) {
      T.R(row, static_cast<Eigen::Index>(j)) = rows.at(i).at(j).get<double>();
    }
    T.p(row) = rows.at(i).at(3).get<double>();
  }
  return T;
}

// `cameras` of the summary, where it is there.
void add_cameras(const Json& summary, Time first, Channels& out) {
  const auto cameras = summary.find("cameras");
  if (cameras == summary.end() || !cameras->is_array() || cameras->empty()) return;
  Json transforms = Json::array();
  try {
    for (std::size_t k = 0; k < cameras->size(); ++k) {
      transforms.push_back(proto_transform(first, "imu", fmt::format("cam{}", k),
                                           motion(cameras->at(k).at("imu_T_cam"))));
    }
  } catch (const Json::exception&) {
    throw InputError("summary.json: cameras: expected imu_T_cam, 4 x 4 numbers, of each");
  }
  out.add("/tf_cameras", "foxglove.FrameTransforms", first, {{"transforms", transforms}});
}

void add_truth(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!errors.problem.empty()) return;
  for (std::size_t i = 0; i < errors.matched.truth.size(); ++i) {
    const StampedPose& truth = errors.matched.truth[i];
    const Time time = run.states[errors.matched.estimate_index[i]].time;
    out.add("/truth/pose", "foxglove.PoseInFrame", time,
            {{"timestamp", proto_time(time)},
             {"frame_id", "world"},
             {"pose", proto_pose(errors.world_T_truth_first * truth.pose)}});
  }
}

Json line(const std::string& id, const Trajectory& way, const SE3& placed, unsigned colour,
          Time first) {
  Json points = Json::array();
  for (const StampedPose& s : way) points.push_back(proto_vector(placed * s.pose.p));
  return {{"timestamp", proto_time(first)},
          {"frame_id", "world"},
          {"id", id},
          {"lines", Json::array({{{"type", 0},
                                  {"pose", proto_pose({})},
                                  {"thickness", 2.0},
                                  {"scale_invariant", true},
                                  {"points", std::move(points)},
                                  {"color", proto_colour(colour, 1)}}})}};
}

void add_ways(const Run& run, const AgainstTruth& errors, Time first, Channels& out) {
  Json entities = Json::array({line("estimate", finite_poses(run), {}, kEstimateColour, first)});
  if (!run.truth.empty() && errors.problem.empty()) {
    entities.push_back(line("truth", run.truth, errors.world_T_truth_first, kTruthColour, first));
  }
  if (!run.dead_reckoning.empty()) {
    entities.push_back(line("dead reckoning", run.dead_reckoning, {}, kDeadReckoningColour, first));
  }
  out.add("/ways", "foxglove.SceneUpdate", first, {{"entities", std::move(entities)}});
}

void add_places(const Run& run, const AgainstTruth& errors, Channels& out) {
  if (!run.georeference || !errors.problem.empty()) return;
  const SE3 placed = truth_T_world(run);
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.p.allFinite()) continue;
    const Geodetic place = to_geodetic(*run.georeference, placed * s.world_T_imu.p);
    const Eigen::Matrix3d P =
        placed.R * s.pose_covariance.bottomRightCorner<3, 3>() * placed.R.transpose();
    out.add("/location", "foxglove.LocationFix", s.time,
            {{"timestamp", proto_time(s.time)},
             {"frame_id", "imu"},
             {"latitude", place.latitude},
             {"longitude", place.longitude},
             {"altitude", place.altitude},
             {"position_covariance", std::vector<double>(P.data(), P.data() + P.size())},
             {"position_covariance_type", 3}});
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
    add_cameras(summary, first, out);
    add_states(run, out);
    add_errors(run, errors, out);
    add_truth(run, errors, out);
    add_ways(run, errors, first, out);
    add_map(run.landmarks, first, out);
    if (run.prior_map) add_prior_map(run, first, out);
    add_map_frame(run, out);
    add_closures(summary, run, out);
    add_places(run, errors, out);
    add_images(run.images, out);
  }
  return mcap_bytes(out.file());
}

}  // namespace chasles
