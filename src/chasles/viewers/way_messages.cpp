#include <nlohmann/json.hpp>

#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/way_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

}  // namespace

Json way(const std::string& id, const Trajectory& poses, const SE3& world_T_poses, unsigned colour,
         Time time) {
  Json points = Json::array();
  for (const StampedPose& s : poses) points.push_back(proto_vector(world_T_poses * s.pose.p));
  return {{"timestamp", proto_time(time)},
          {"frame_id", "world"},
          {"id", id},
          {"lines", Json::array({{{"type", 0},
                                  {"pose", proto_pose({})},
                                  {"thickness", 2.0},
                                  {"scale_invariant", true},
                                  {"points", std::move(points)},
                                  {"color", proto_colour(colour, 1)}}})}};
}

}  // namespace chasles
