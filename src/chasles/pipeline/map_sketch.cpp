#include <chasles/pipeline/map_sketch.hpp>

namespace chasles {

MapSketch map_sketch(const LandmarkMap& map) {
  MapSketch sketch;
  for (const MapSession& session : map.sessions) {
    sketch.sessions.push_back({.name = session.name,
                               .begin = session.begin,
                               .end = session.end,
                               .cameras = static_cast<int>(session.cameras.size())});
  }
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const MapPoint& point = map.points[i];
    const Eigen::Matrix3d covariance = map.covariance.of(static_cast<int>(i));
    const double own = map.covariance.own()[i].trace(), all = covariance.trace();
    sketch.points.push_back({.id = kFirstMapId + static_cast<LandmarkId>(i),
                             .session = point.session,
                             .p_map = point.p_map,
                             .covariance = covariance,
                             .own = all > 0 ? own / all : 1,
                             .observations = point.observations,
                             .views = static_cast<int>(point.appearance.views().size())});
  }
  return sketch;
}

}  // namespace chasles
