#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/report/columns.hpp>
#include <chasles/report/map_data.hpp>

namespace chasles {

using Json = nlohmann::ordered_json;

Json map_json(const MapSketch& map, const std::vector<RunLandmark>& landmarks,
              const Eigen::Vector3d& origin) {
  Json sessions = Json::array();
  for (const SketchSession& session : map.sessions) {
    sessions.push_back({{"name", session.name},
                        {"begin", to_seconds(session.begin)},
                        {"seconds", to_seconds(session.end - session.begin)},
                        {"cameras", session.cameras}});
  }
  std::set<LandmarkId> returned;
  for (const RunLandmark& landmark : landmarks) returned.insert(landmark.id);
  const SE3& world_T_map = map.world_T_map;
  Json marks;
  marks["id"] = double_column(
      values<double>(map.points, [](const SketchPoint& p) { return static_cast<double>(p.id); }));
  add_points(marks, "", map.points, [&](const SketchPoint& p) -> Eigen::Vector3d {
    return world_T_map * p.p_map - origin;
  });
  add_covariances(marks, map.points, [&](const SketchPoint& p) -> Eigen::Matrix3d {
    return world_T_map.R * p.covariance * world_T_map.R.transpose();
  });
  marks["session"] = ints(map.points, [](const SketchPoint& p) { return p.session; });
  marks["own"] = floats(map.points, [](const SketchPoint& p) { return p.own; });
  marks["observations"] = ints(map.points, [](const SketchPoint& p) { return p.observations; });
  marks["views"] = ints(map.points, [](const SketchPoint& p) { return p.views; });
  marks["returned"] =
      ints(map.points, [&](const SketchPoint& p) { return returned.contains(p.id) ? 1 : 0; });
  return {{"sessions", std::move(sessions)}, {"marks", std::move(marks)}};
}

}  // namespace chasles
