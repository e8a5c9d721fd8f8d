#include <set>
#include <unordered_map>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/report/columns.hpp>
#include <chasles/report/map_data.hpp>

namespace chasles {

using Json = nlohmann::ordered_json;

Json map_json(const Run& run, const Eigen::Vector3d& origin) {
  const MapSketch& map = *run.prior_map;
  Json sessions = Json::array();
  for (const SketchSession& session : map.sessions) {
    sessions.push_back({{"name", session.name},
                        {"begin", to_seconds(session.begin)},
                        {"seconds", to_seconds(session.end - session.begin)},
                        {"cameras", session.cameras}});
  }
  // What the run knows of them now, else as the map has them.
  std::unordered_map<LandmarkId, const RunLandmark*> known;
  for (const RunLandmark& landmark : run.landmarks) known[landmark.id] = &landmark;
  std::vector<UncertainPoint> places;
  for (const SketchPoint& p : map.points) {
    const auto found = known.find(p.id);
    const Eigen::Matrix3d& R = map.world_T_map.R;
    places.push_back(
        found == known.end()
            ? UncertainPoint{map.world_T_map * p.p_map, R * p.covariance * R.transpose()}
            : UncertainPoint{found->second->p_world, found->second->covariance});
  }
  const std::set<LandmarkId> recognised = recognised_landmarks(run);
  Json marks;
  marks["id"] = double_column(
      values<double>(map.points, [](const SketchPoint& p) { return static_cast<double>(p.id); }));
  add_points(marks, "", places,
             [&](const UncertainPoint& p) -> Eigen::Vector3d { return p.p_world - origin; });
  add_covariances(marks, places, [](const UncertainPoint& p) { return p.covariance; });
  marks["session"] = ints(map.points, [](const SketchPoint& p) { return p.session; });
  marks["own"] = floats(map.points, [](const SketchPoint& p) { return p.own; });
  marks["observations"] = ints(map.points, [](const SketchPoint& p) { return p.observations; });
  marks["views"] = ints(map.points, [](const SketchPoint& p) { return p.views; });
  marks["returned"] =
      ints(map.points, [&](const SketchPoint& p) { return recognised.contains(p.id) ? 1 : 0; });
  return {{"sessions", std::move(sessions)}, {"marks", std::move(marks)}};
}

}  // namespace chasles
