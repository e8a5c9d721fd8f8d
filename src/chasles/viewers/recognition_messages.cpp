#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/point_cloud.hpp>
#include <chasles/viewers/recognition_messages.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

constexpr double kMarker = 0.3;  // diameter of a closure's sphere [m]

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

Json closure_message(const Json& closure, std::size_t number, const RunState& state) {
  const Json pose = proto_pose({Eigen::Matrix3d::Identity(), state.world_T_imu.p});
  const Json colour = proto_colour(kClosureColour, 0.8);
  const Json sphere = {{"pose", pose},
                       {"size", proto_vector(Eigen::Vector3d::Constant(kMarker))},
                       {"color", colour}};
  const Json text = {{"pose", pose},      {"billboard", true},
                     {"font_size", 14.0}, {"scale_invariant", true},
                     {"color", colour},   {"text", closure_text(closure)}};
  return {{"entities", Json::array({{{"timestamp", proto_time(state.time)},
                                     {"frame_id", "world"},
                                     {"id", fmt::format("closure {}", number)},
                                     {"spheres", Json::array({sphere})},
                                     {"texts", Json::array({text})}}})}};
}

}  // namespace

Json map_frame_message(Time time, const SE3& map_T_world) {
  if (!is_finite(map_T_world)) return nullptr;
  return {{"transforms", Json::array({proto_transform(time, "map", "world", map_T_world)})}};
}

Json prior_map_message(const Run& run, Time time) {
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
  return cloud.message(time);
}

void closure_messages(const Json& summary, const Run& run,
                      const std::function<void(Time, const Json&)>& take) {
  const auto closures = summary.find("closures");
  if (closures == summary.end()) return;
  try {
    for (std::size_t k = 0; k < closures->size(); ++k) {
      const Json& closure = closures->at(k);
      const RunState* state = state_at(run, Time(closure.at("time_ns").get<std::int64_t>()));
      if (!state || !is_finite(state->world_T_imu)) continue;
      take(state->time, closure_message(closure, k, *state));
    }
  } catch (const Json::exception&) {
    throw InputError(
        "summary.json: closures: expected time_ns, landmarks and moved_m of each, numbers");
  }
}

void add_map_frame(const Run& run, Channels& out) {
  for (const SmoothedPose& in_map : run.in_map) {
    const RunState* state = state_at(run, in_map.time);
    if (!state || state->time != in_map.time) continue;
    const SE3 map_T_world = in_map.world_T_imu * state->world_T_imu.inverse();
    const Json message = map_frame_message(in_map.time, map_T_world);
    if (!message.is_null()) out.add(kTfMapTopic, in_map.time, message);
  }
}

}  // namespace chasles
