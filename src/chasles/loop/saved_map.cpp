#include <algorithm>
#include <utility>

#include <chasles/loop/saved_map.hpp>
#include <chasles/loop/spatial_choice.hpp>

namespace chasles {
namespace {

struct SavedLandmark {
  enum Kind { kOfMap, kPast, kInState };
  LandmarkId id = 0;
  Kind kind = kOfMap;  ///< kOfMap: of the prior map, and has not returned
  int place = 0;       ///< number in Ekf::past(), or index into the state's landmarks
  int observations = 0;
  Appearance appearance;
};

// Those of the map come first, so that own ones give way where both cover a place. In the result,
// those that follow from the map's shared errors come first, then past ones by number, then those
// of the state.
std::vector<SavedLandmark> landmarks_to_save(const MappedLandmarks& all, const SE3& map_T_nav,
                                             int most, std::optional<Time> until) {
  SpatialChoice choice(most);
  std::vector<SavedLandmark> saved;
  const Ekf& filter = all.filter;
  const State& x = filter.state();
  const auto add = [&](SavedLandmark landmark, const Eigen::Vector3d& p_nav) {
    landmark.appearance = landmark.appearance.turned(map_T_nav.R);
    if (landmark.appearance.empty()) return;
    const PatchView& view = landmark.appearance.views().front();
    const bool chosen = choice.choose(landmark.id, map_T_nav * p_nav, view.distance(), view.from);
    if (chosen || landmark.id >= kFirstMapId) saved.push_back(std::move(landmark));
  };
  for (const bool of_map : {true, false}) {
    for (const auto& [id, past] : all.past) {
      if ((id >= kFirstMapId) != of_map) continue;
      if (!of_map && until && past.left >= *until) continue;
      const bool follows = filter.past().follows(past.number);
      add({.id = id,
           .kind = follows ? SavedLandmark::kOfMap : SavedLandmark::kPast,
           .place = past.number,
           .observations = filter.past().landmark(past.number).observations,
           .appearance = past.appearance},
          past.p_nav);
    }
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      const Landmark& landmark = x.landmarks[i];
      const auto known = all.appearances.find(landmark.id);
      const bool usable = known != all.appearances.end() && !landmark.anchor &&
                          landmark.observations >= kLeastObservations && (of_map || !until);
      if ((landmark.id >= kFirstMapId) != of_map || !usable) continue;
      add({.id = landmark.id,
           .kind = landmark.considered ? SavedLandmark::kOfMap : SavedLandmark::kInState,
           .place = landmark.considered.value_or(static_cast<int>(i)),
           .observations = landmark.observations,
           .appearance = known->second},
          x.nav_T_world ? *x.nav_T_world * landmark.p_world : landmark.p_world);
    }
  }
  std::ranges::sort(saved, {}, [](const SavedLandmark& s) { return std::pair(s.kind, s.place); });
  return saved;
}

}  // namespace

LandmarkMap saved_map(const MappedLandmarks& landmarks, std::span<const Camera> cameras, int most,
                      Time end, std::optional<Time> until) {
  using Eigen::Index;
  using Eigen::Matrix3d;
  using Eigen::MatrixXd;
  using Eigen::Vector3d;
  const Ekf& filter = landmarks.filter;
  const std::optional<PlacedMap>& placed = landmarks.placed;
  const SE3 map_T_nav = (placed ? placed->nav_T_map(filter) : SE3{}).inverse();
  std::vector<SavedLandmark> saved = landmarks_to_save(landmarks, map_T_nav, most, until);
  std::vector<int> numbers, indices;
  for (const SavedLandmark& s : saved) {
    if (s.kind == SavedLandmark::kPast) numbers.push_back(s.place);
    if (s.kind == SavedLandmark::kInState) indices.push_back(s.place);
  }
  if (placed) {
    numbers.insert(std::ranges::lower_bound(numbers, placed->number()), placed->number());
  }
  const Carried joint = filter.past().recall(numbers, indices);
  std::vector<Index> of_map, of_others;
  Index at = 0;
  for (const Segment::Item& item : joint.items) {
    const bool shared = placed && item.number == placed->number();
    for (int i = 0; i < item.size; ++i) (shared ? of_map : of_others).push_back(at++);
  }
  const auto r = static_cast<Index>(of_map.size());
  const SharedPart part = shared_part(joint.P(of_map, of_map), joint.P(of_others, of_map),
                                      joint.P(of_others, of_others));

  LandmarkMap map;
  if (placed) map.sessions = placed->map().sessions;
  const auto own_session = static_cast<int>(map.sessions.size());
  map.sessions.push_back(
      {.name = {}, .begin = {}, .end = end, .cameras = {cameras.begin(), cameras.end()}});
  MatrixXd shared = MatrixXd::Zero(3 * static_cast<Index>(saved.size()), part.others.rank());
  std::vector<Matrix3d> own;
  MatrixXd frame = MatrixXd::Zero(6, shared.cols());
  if (placed) {
    frame.leftCols(r) = filter.past().prior(placed->number()).shared.topRows<6>() * part.root;
  }
  Index other = 0;  // row of the others
  for (std::size_t i = 0; i < saved.size(); ++i) {
    SavedLandmark& s = saved[i];
    const bool known = s.id >= kFirstMapId;
    const auto index = static_cast<std::size_t>(s.id - kFirstMapId);
    Vector3d p_map;
    auto rows = shared.middleRows<3>(3 * static_cast<Index>(i));
    if (s.kind == SavedLandmark::kOfMap) {
      // In the frame of the map the place moves nothing.
      const Index shared_by_map = r - 4;
      const JointCovariance& covariance = placed->map().covariance;
      const MatrixXd U = covariance.shared().middleRows<3>(3 * static_cast<Index>(index));
      p_map = placed->map().points[index].p_map + U * joint.correction(of_map).head(shared_by_map);
      rows.leftCols(r) = U * part.root.topRows(shared_by_map);
      own.push_back(covariance.own()[index]);
    } else {
      Vector3d p_nav = joint.correction(of_others).segment<3>(other);
      if (s.kind == SavedLandmark::kPast) p_nav += filter.past().landmark(s.place).p_world;
      p_map = map_T_nav * p_nav;
      const Matrix3d& R = map_T_nav.R;
      rows = R * part.others.shared().middleRows<3>(other) + hat(p_map) * R * frame.topRows<3>() -
             R * frame.bottomRows<3>();
      own.push_back(R * part.others.own()[static_cast<std::size_t>(other / 3)] * R.transpose());
      other += 3;
    }
    map.points.push_back({.p_map = p_map,
                          .session = known ? placed->map().points[index].session : own_session,
                          .observations = s.observations,
                          .appearance = std::move(s.appearance)});
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared)).reduced({});
  return map;
}

}  // namespace chasles
