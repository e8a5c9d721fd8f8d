#include <algorithm>
#include <utility>

#include <chasles/loop/saved_map.hpp>
#include <chasles/loop/spatial_choice.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

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

// The joint estimate of the landmarks to save: the variables that those of the prior map share with
// the run, and the own landmarks.
struct JointEstimate {
  Carried carried = {};
  std::vector<Index> of_map = {}, of_others = {};  ///< its rows
  SharedPart part = {};
};

JointEstimate joint_estimate(const MappedLandmarks& landmarks,
                             const std::vector<SavedLandmark>& saved) {
  const std::optional<PlacedMap>& placed = landmarks.placed;
  std::vector<int> numbers, indices;
  for (const SavedLandmark& s : saved) {
    if (s.kind == SavedLandmark::kPast) numbers.push_back(s.place);
    if (s.kind == SavedLandmark::kInState) indices.push_back(s.place);
  }
  if (placed) {
    numbers.insert(std::ranges::lower_bound(numbers, placed->number()), placed->number());
  }
  JointEstimate joint{.carried = landmarks.filter.past().recall(numbers, indices)};
  Index at = 0;
  for (const Segment::Item& item : joint.carried.items) {
    const bool shared = placed && item.number == placed->number();
    for (int i = 0; i < item.size; ++i) (shared ? joint.of_map : joint.of_others).push_back(at++);
  }
  const MatrixXd& P = joint.carried.P;
  joint.part = shared_part(P(joint.of_map, joint.of_map), P(joint.of_others, joint.of_map),
                           P(joint.of_others, joint.of_others));
  return joint;
}

// A landmark in the frame of the map. Its error is rows * (shared errors) + an own one.
struct PointInMap {
  Vector3d p_map;
  MatrixXd rows;
  Matrix3d own;
};

// Of the prior map, and not returned: the place moves nothing in the frame of the map.
PointInMap point_of_map(const PlacedMap& placed, const JointEstimate& joint, std::size_t index) {
  const auto r = static_cast<Index>(joint.of_map.size());
  const Index shared_by_map = r - 4;
  const JointCovariance& covariance = placed.map().covariance;
  const MatrixXd U = covariance.shared().middleRows<3>(3 * static_cast<Index>(index));
  PointInMap point{.p_map = placed.map().points[index].p_map +
                            U * joint.carried.correction(joint.of_map).head(shared_by_map),
                   .rows = MatrixXd::Zero(3, joint.part.others.rank()),
                   .own = covariance.own()[index]};
  point.rows.leftCols(r) = U * joint.part.root.topRows(shared_by_map);
  return point;
}

// An own one, whose error in nav has the rows from `row` on of the others. `frame`: the error of
// the map's place by the shared errors.
PointInMap own_point(const Vector3d& p_past, const JointEstimate& joint, Index row,
                     const SE3& map_T_nav, const MatrixXd& frame) {
  const Matrix3d& R = map_T_nav.R;
  const Vector3d p_nav = joint.carried.correction(joint.of_others).segment<3>(row) + p_past;
  const Vector3d p_map = map_T_nav * p_nav;
  const JointCovariance& others = joint.part.others;
  return {.p_map = p_map,
          .rows = R * others.shared().middleRows<3>(row) + hat(p_map) * R * frame.topRows<3>() -
                  R * frame.bottomRows<3>(),
          .own = R * others.own()[static_cast<std::size_t>(row / 3)] * R.transpose()};
}

MapSession own_session(std::span<const Camera> cameras, Time end) {
  return {.name = {}, .begin = {}, .end = end, .cameras = {cameras.begin(), cameras.end()}};
}

}  // namespace

LandmarkMap saved_map(const MappedLandmarks& landmarks, std::span<const Camera> cameras, int most,
                      Time end, std::optional<Time> until) {
  const Ekf& filter = landmarks.filter;
  const std::optional<PlacedMap>& placed = landmarks.placed;
  const SE3 map_T_nav = (placed ? placed->nav_T_map(filter) : SE3{}).inverse();
  std::vector<SavedLandmark> saved = landmarks_to_save(landmarks, map_T_nav, most, until);
  const JointEstimate joint = joint_estimate(landmarks, saved);

  LandmarkMap map;
  if (placed) map.sessions = placed->map().sessions;
  const auto session = static_cast<int>(map.sessions.size());
  map.sessions.push_back(own_session(cameras, end));
  MatrixXd frame = MatrixXd::Zero(6, joint.part.others.rank());
  if (placed) {
    frame.leftCols(static_cast<Index>(joint.of_map.size())) =
        filter.past().prior(placed->number()).shared.topRows<6>() * joint.part.root;
  }
  MatrixXd shared(3 * static_cast<Index>(saved.size()), frame.cols());
  std::vector<Matrix3d> own;
  Index other = 0;  // row of the others
  for (std::size_t i = 0; i < saved.size(); ++i) {
    SavedLandmark& s = saved[i];
    const auto index = static_cast<std::size_t>(s.id - kFirstMapId);
    PointInMap point;
    if (s.kind == SavedLandmark::kOfMap) {
      point = point_of_map(*placed, joint, index);
    } else {
      const bool is_past = s.kind == SavedLandmark::kPast;
      point = own_point(is_past ? filter.past().landmark(s.place).p_world : Vector3d(0, 0, 0),
                        joint, other, map_T_nav, frame);
      other += 3;
    }
    shared.middleRows<3>(3 * static_cast<Index>(i)) = point.rows;
    own.push_back(point.own);
    map.points.push_back(
        {.p_map = point.p_map,
         .session = s.id >= kFirstMapId ? placed->map().points[index].session : session,
         .observations = s.observations,
         .appearance = std::move(s.appearance)});
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared)).reduced({});
  return map;
}

}  // namespace chasles
