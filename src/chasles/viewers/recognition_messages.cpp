#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/point_cloud.hpp>
#include <chasles/viewers/recognition_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr double kMarker = 0.3;  // diameter of a closure's sphere [m]

bool is_finite(const SE3& pose) { return pose.p.allFinite() && pose.R.allFinite(); }

// The state at that time, or the first after it; null where there is none.
const RunState* state_at(const Run& run, Time time) {
  const auto found = std::ranges::lower_bound(run.states, time, {}, &RunState::time);
  return found == run.states.end() ? nullptr : &*found;
}

std::string closure_text(const Json& closure) {
  std::string text = fmt::format("{} landmarks, {:.3f} m", closure.at("landmarks").get<int>(),
                                 closure.at("moved_m").get<double>());
  const auto square = closure.find("chi2");  // not in folders of earlier versions
  if (square == closure.end()) return text;
  return text + fmt::format(", chi2 {:.1f} of {}", square->get<double>(),
                            closure.at("chi2_dof").get<int>());
}

void add_closure(const Json& closure, std::size_t number, const Run& run, Channels& out) {
  const RunState* state = state_at(run, Time(closure.at("time_ns").get<std::int64_t>()));
  if (!state || !is_finite(state->world_T_imu)) return;
  const Json pose = proto_pose({Eigen::Matrix3d::Identity(), state->world_T_imu.p});
  const Json colour = proto_colour(kClosureColour, 0.8);
  out.add("/closures", "foxglove.SceneUpdate", state->time,
          {{"entities",
            Json::array({{{"timestamp", proto_time(state->time)},
                          {"frame_id", "world"},
                          {"id", fmt::format("closure {}", number)},
                          {"spheres",
                           Json::array({{{"pose", pose},
                                         {"size", proto_vector(Eigen::Vector3d::Constant(kMarker))},
                                         {"color", colour}}})},
                          {"texts", Json::array({{{"pose", pose},
                                                  {"billboard", true},
                                                  {"font_size", 14.0},
                                                  {"scale_invariant", true},
                                                  {"color", colour},
                                                  {"text", closure_text(closure)}}})}}})}});
}

}  // namespace

void add_map_frame(const Run& run, Channels& out) {
  for (const SmoothedPose& in_map : run.in_map) {
    const RunState* state = state_at(run, in_map.time);
    if (!state || state->time != in_map.time) continue;
    const SE3 map_T_world = in_map.world_T_imu * state->world_T_imu.inverse();
    if (!is_finite(map_T_world)) continue;
    out.add(
        "/tf_map", "foxglove.FrameTransforms", in_map.time,
        {{"transforms", Json::array({proto_transform(in_map.time, "map", "world", map_T_world)})}});
  }
}

void add_prior_map(const Run& run, Time time, Channels& out) {
  const std::set<LandmarkId> returned = recognised_landmarks(run);
  PointCloud cloud("map", {"session", "returned"});
  for (const SketchPoint& l : run.prior_map->points) {
    if (!l.p_map.allFinite() || !l.covariance.allFinite()) continue;
    cloud.add({.p = l.p_map,
               .sigma = std::sqrt(std::max(0.0, l.covariance.trace())),
               .colour = rgb(session_colour(l.session)),
               .more = {static_cast<std::uint8_t>(std::min(l.session, 255)),
                        std::uint8_t{returned.contains(l.id)}}});
  }
  out.add("/map/prior", "foxglove.PointCloud", time, cloud.message(time));
}

void add_closures(const Json& summary, const Run& run, Channels& out) {
  const auto closures = summary.find("closures");
  if (closures == summary.end()) return;
  try {
    for (std::size_t k = 0; k < closures->size(); ++k) {
      add_closure(closures->at(k), k, run, out);
    }
  } catch (const Json::exception&) {
    throw InputError(
        "summary.json: closures: expected time_ns, landmarks and moved_m of each, numbers");
  }
}

}  // namespace chasles
