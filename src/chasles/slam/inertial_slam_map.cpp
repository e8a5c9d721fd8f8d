#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/loop/place.hpp>
#include <chasles/slam/inertial_slam.hpp>

// Maps of earlier runs: finding the place in one, and leaving one (docs/recognition.md).
namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Searches in a row without compatible landmarks after which a proposed place is given up.
constexpr int kPatience = 2;
constexpr int kLeastSeen = 7, kLeastCommon = 3;
// Landmarks that left the state since help to find the place.
constexpr Time kRecently = std::chrono::seconds(4);

}  // namespace

// Whether landmarks of the map have returned, which places it.
bool InertialSlam::find_place_in_map(const std::vector<SeenLandmark>& seen) {
  if (!prior_->place) propose_place(seen);
  if (!prior_->place) return false;
  if (recognise_among(prior_->points, prior_->compatible, seen)) return true;
  // What is compatible may still lack the view from another place.
  prior_->failures = prior_->compatible.empty() ? prior_->failures + 1 : 0;
  if (prior_->failures >= kPatience) {
    ++place_counts_.rejected;
    prior_ = Prior{.map = prior_->map};
  }
  return false;
}

std::optional<PlaceInMap> InertialSlam::search_place(const std::vector<SeenLandmark>& seen) {
  if (seen.size() < kLeastSeen) return std::nullopt;
  ++place_counts_.searches;
  const State& x = filter_.state();
  std::vector<PlacePoint> points;
  for (const SeenLandmark& s : seen) {
    const Vector3d p_world = x.p_world(x.landmarks[static_cast<std::size_t>(s.index)]);
    points.push_back(
        {.p_world = x.nav_T_world ? *x.nav_T_world * p_world : p_world, .view = s.view});
  }
  for (const auto& [id, inactive] : inactive_) {
    if (now_ - inactive.left > kRecently) continue;
    points.push_back({.p_world = inactive.p_nav, .view = inactive.appearance.views().front()});
  }
  return find_place(points, nav_T_camera(0).p, *prior_->map);
}

void InertialSlam::propose_place(const std::vector<SeenLandmark>& seen) {
  const auto place = search_place(seen);
  if (!place) return;
  ++place_counts_.proposed;
  prior_->place = MapPlace{.world_T_map = place->world_T_map, .pivot = nav_T_camera(0).p};
  put_points_in_place();
}

// Where places look alike, one of them may stand out by chance among the landmarks of one moment.
// Whether the search finds the proposed place once more, by pairs that are accepted.
bool InertialSlam::finds_place_again(const Comparison& comparison, const std::vector<int>& accepted,
                                     const std::vector<Candidate>& candidates,
                                     const std::vector<SeenLandmark>& seen) {
  const auto place = search_place(seen);
  if (!place) return false;
  return kLeastCommon <= std::ranges::count_if(accepted, [&](int i) {
           const ProposedMatch& match = comparison.matches[static_cast<std::size_t>(i)];
           const int point = candidates[static_cast<std::size_t>(match.landmark)].inactive->number;
           return std::ranges::any_of(place->matches, [&](const PlaceInMap::Match& m) {
             return m.seen == match.observation && m.point == point;
           });
         });
}

void InertialSlam::put_points_in_place() {
  const SE3& nav_T_map = prior_->place->world_T_map;
  for (std::size_t i = 0; i < prior_->map->points.size(); ++i) {
    const MapPoint& point = prior_->map->points[i];
    prior_->points[kFirstMapId + static_cast<LandmarkId>(i)] = {
        .number = static_cast<int>(i),
        .p_nav = nav_T_map * point.p_map,
        .appearance = point.appearance.turned(nav_T_map.R)};
  }
}

// The whole map is linearised at its place: an error of the heading of 0.03 rad would make it 5 cm
// larger in 100 m. So the accepted matches determine the place first. They count when the landmarks
// are observed; the place is then no more than where these are linearised.
void InertialSlam::refine_place(const Comparison& comparison, const std::vector<int>& accepted,
                                const std::vector<Candidate>& candidates,
                                const std::vector<SeenLandmark>& seen) {
  constexpr int kRefinements = 3;
  std::vector<Candidate> matched;
  for (const int i : accepted) {
    const ProposedMatch& match = comparison.matches[static_cast<std::size_t>(i)];
    matched.push_back(candidates[static_cast<std::size_t>(match.landmark)]);
    matched.back().like = {{0, match.observation}};
  }
  std::ranges::sort(matched, {}, [](const Candidate& c) { return c.inactive->number; });
  for (int step = 0; step < kRefinements; ++step) {
    Comparison now = compare(matched, known_points(matched), seen);
    now.S.diagonal().array() += pixel_sigma_ * pixel_sigma_ + kOtherPoint * kOtherPoint;
    const Eigen::Vector4d error = now.by_place.transpose() * now.S.ldlt().solve(now.r);
    MapPlace& place = *prior_->place;
    const Matrix3d turn = so3::exp(Vector3d(0, 0, place.heading_sigma * error[0]));
    SE3& nav_T_map = place.world_T_map;
    nav_T_map.R = turn * nav_T_map.R;
    nav_T_map.p =
        place.pivot + turn * (nav_T_map.p - place.pivot) + place.position_sigma * error.tail<3>();
  }
  put_points_in_place();
}

// The place is accepted: the map's landmarks become past landmarks of the filter.
void InertialSlam::place_map() {
  std::vector<int> all(prior_->map->points.size());
  std::iota(all.begin(), all.end(), 0);
  PriorMap placed_map = placed(*prior_->map, all, *prior_->place);
  map_number_ = considers_map() ? filter_.consider(std::move(placed_map))
                                : filter_.add_past(std::move(placed_map));
  for (auto& [id, point] : prior_->points) point.number += *map_number_ + 1;
  inactive_.merge(prior_->points);
  placed_map_ = prior_->map;
  place_counts_.placed = clock(now_);
  prior_.reset();
}

InertialSlam::KnownLandmarks InertialSlam::known_points(
    const std::vector<Candidate>& candidates) const {
  std::vector<int> points;
  for (const Candidate& c : candidates) points.push_back(c.inactive->number);
  const PriorMap known = placed(*prior_->map, points, *prior_->place);
  const auto k = 3 * static_cast<Index>(points.size());
  const MatrixXd A = known.shared.bottomRows(k), A_transposed = A.transpose();
  MatrixXd P = dense::product(A, A_transposed);
  for (Index i = 0; i < k; i += 3) {
    P.block<3, 3>(i, i) += known.own[static_cast<std::size_t>(i / 3)];
  }
  return {.landmarks = known.landmarks,
          .C = MatrixXd::Zero(k, filter_.covariance().rows()),
          .P = std::move(P),
          .by_place = A.rightCols<4>()};
}

// The frame of the map follows from the shared errors of its landmarks.
InertialSlam::MapFrame InertialSlam::map_frame(const Carried& shared) const {
  const PriorMap& prior = filter_.past().prior(*map_number_);
  const Eigen::Index r = prior.shared.cols();
  MapFrame frame{.nav_T_map = {}, .by_shared = prior.shared.topRows<6>()};
  const Vector6d correction = frame.by_shared * shared.correction.head(r);
  frame.nav_T_map =
      corrected({.map_T_imu = prior.map_T_prior}, correction, Matrix6d::Zero()).map_T_imu;
  return frame;
}

std::optional<SE3> InertialSlam::nav_T_map() const {
  if (!map_number_) return std::nullopt;
  return map_frame(filter_.past().recall(std::array{*map_number_})).nav_T_map;
}

std::optional<PoseInMap> InertialSlam::pose_in_map(const NavState& now) const {
  if (!map_number_) return std::nullopt;
  const Carried shared = filter_.past().recall(std::array{*map_number_});
  const MapFrame frame = map_frame(shared);
  const MatrixXd& B = frame.by_shared;
  const MatrixXd pose = work_.nav.derivative.topRows<6>();
  // The errors of the frame and of the pose in nav.
  Eigen::Matrix<double, 12, 12> P;
  P.topLeftCorner<6, 6>() = B * shared.P * B.transpose();
  P.bottomRightCorner<6, 6>() = now.covariance.topLeftCorner<6, 6>();
  P.topRightCorner<6, 6>() = B * shared.C.leftCols(pose.cols()) * pose.transpose();
  P.bottomLeftCorner<6, 6>() = P.topRightCorner<6, 6>().transpose();
  const SE3& nav_T_map = frame.nav_T_map;
  const Matrix3d map_R_nav = nav_T_map.R.transpose();
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.block<3, 3>(0, 0) = -map_R_nav;
  J.block<3, 3>(0, 6) = map_R_nav;
  J.block<3, 3>(3, 0) = map_R_nav * hat(now.nav_T_imu.p - nav_T_map.p);
  J.block<3, 3>(3, 3) = -map_R_nav;
  J.block<3, 3>(3, 9) = map_R_nav;
  return PoseInMap{.map_T_imu = nav_T_map.inverse() * now.nav_T_imu,
                   .covariance = J * P * J.transpose(),
                   .world_T_map = nav_T_map};
}

// Those of the map come first, so that own ones give way where both cover a place. In the result,
// those that follow from the map's shared errors come first, then past ones by number, then those
// of the state.
std::vector<InertialSlam::SavedLandmark> InertialSlam::landmarks_to_save(
    const SE3& map_T_nav, std::optional<Time> until) const {
  SpatialChoice choice(settings_.recognisable);
  std::vector<SavedLandmark> saved;
  const State& x = filter_.state();
  const auto add = [&](SavedLandmark landmark, const Vector3d& p_nav) {
    landmark.appearance = landmark.appearance.turned(map_T_nav.R);
    if (landmark.appearance.empty()) return;
    const PatchView& view = landmark.appearance.views().front();
    const bool chosen = choice.choose(landmark.id, map_T_nav * p_nav, view.distance(), view.from);
    if (chosen || landmark.id >= kFirstMapId) saved.push_back(std::move(landmark));
  };
  for (const bool of_map : {true, false}) {
    for (const auto& [id, inactive] : inactive_) {
      if ((id >= kFirstMapId) != of_map) continue;
      if (!of_map && until && inactive.left >= *until) continue;
      const bool follows = filter_.past().follows(inactive.number);
      add({.id = id,
           .kind = follows ? SavedLandmark::kOfMap : SavedLandmark::kPast,
           .place = inactive.number,
           .observations = filter_.past().landmark(inactive.number).observations,
           .appearance = inactive.appearance},
          inactive.p_nav);
    }
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      const Landmark& landmark = x.landmarks[i];
      const auto known = appearances_.find(landmark.id);
      const bool usable = known != appearances_.end() && !landmark.anchor &&
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

LandmarkMap InertialSlam::landmark_map(std::optional<Time> until) const {
  const SE3 map_T_nav = nav_T_map().value_or(SE3{}).inverse();
  std::vector<SavedLandmark> saved = landmarks_to_save(map_T_nav, until);
  std::vector<int> numbers, indices;
  for (const SavedLandmark& s : saved) {
    if (s.kind == SavedLandmark::kPast) numbers.push_back(s.place);
    if (s.kind == SavedLandmark::kInState) indices.push_back(s.place);
  }
  if (map_number_) numbers.insert(std::ranges::lower_bound(numbers, *map_number_), *map_number_);
  const Carried joint = filter_.past().recall(numbers, indices);
  std::vector<Index> of_map, of_others;
  Index at = 0;
  for (const Segment::Item& item : joint.items) {
    const bool shared = map_number_ && item.number == *map_number_;
    for (int i = 0; i < item.size; ++i) (shared ? of_map : of_others).push_back(at++);
  }
  const auto r = static_cast<Index>(of_map.size());
  const SharedPart part = shared_part(joint.P(of_map, of_map), joint.P(of_others, of_map),
                                      joint.P(of_others, of_others));

  LandmarkMap map;
  if (placed_map_) map.sessions = placed_map_->sessions;
  const auto own_session = static_cast<int>(map.sessions.size());
  map.sessions.push_back({.name = {}, .begin = {}, .end = clock(now_), .cameras = cameras_});
  MatrixXd shared = MatrixXd::Zero(3 * static_cast<Index>(saved.size()), part.others.rank());
  std::vector<Matrix3d> own;
  MatrixXd frame = MatrixXd::Zero(6, shared.cols());
  if (map_number_) {
    frame.leftCols(r) = filter_.past().prior(*map_number_).shared.topRows<6>() * part.root;
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
      const MatrixXd U =
          placed_map_->covariance.shared().middleRows<3>(3 * static_cast<Index>(index));
      p_map = placed_map_->points[index].p_map + U * joint.correction(of_map).head(shared_by_map);
      rows.leftCols(r) = U * part.root.topRows(shared_by_map);
      own.push_back(placed_map_->covariance.own()[index]);
    } else {
      Vector3d p_nav = joint.correction(of_others).segment<3>(other);
      if (s.kind == SavedLandmark::kPast) p_nav += filter_.past().landmark(s.place).p_world;
      p_map = map_T_nav * p_nav;
      const Matrix3d& R = map_T_nav.R;
      rows = R * part.others.shared().middleRows<3>(other) + hat(p_map) * R * frame.topRows<3>() -
             R * frame.bottomRows<3>();
      own.push_back(R * part.others.own()[static_cast<std::size_t>(other / 3)] * R.transpose());
      other += 3;
    }
    map.points.push_back({.p_map = p_map,
                          .session = known ? placed_map_->points[index].session : own_session,
                          .observations = s.observations,
                          .appearance = std::move(s.appearance)});
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared)).reduced({});
  return map;
}

}  // namespace chasles
