#include <algorithm>
#include <utility>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/map/place.hpp>
#include <chasles/slam/inertial_slam.hpp>

// Maps of earlier runs: finding the place in one, and leaving one (docs/recognition.md).
namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// The proposed place is where the measurements of the map's landmarks are linearised. As prior
// knowledge it has sigmas that say nothing beside them.
constexpr double kHeadingSigma = 0.3, kPositionSigma = 5;  // [rad, m]
// Searches after which a proposed place that was not accepted is given up.
constexpr int kPatience = 8;
constexpr int kLeastSeen = 7;

std::vector<int> indices_of(std::size_t count) {
  std::vector<int> indices(count);
  for (std::size_t i = 0; i < count; ++i) indices[i] = static_cast<int>(i);
  return indices;
}

}  // namespace

// Whether landmarks of the map have returned, which places it.
bool InertialSlam::find_place_in_map(const std::vector<SeenLandmark>& seen) {
  if (!prior_->nav_T_map) propose_place(seen);
  if (!prior_->nav_T_map) return false;
  if (recognise_among(prior_->points, seen)) {
    placed_map_ = prior_->map;
    place_counts_.placed = clock(now_);
    prior_.reset();
    return true;
  }
  prior_->failures += compatible_.empty() ? kPatience / 2 : 1;
  if (prior_->failures >= kPatience) {
    ++place_counts_.refused;
    prior_ = Prior{.map = prior_->map};
    compatible_.clear();
  }
  return false;
}

void InertialSlam::propose_place(const std::vector<SeenLandmark>& seen) {
  if (seen.size() < kLeastSeen) return;
  ++place_counts_.searches;
  const State& x = filter_.state();
  std::vector<PlacePoint> points;
  for (const SeenLandmark& s : seen) {
    const Vector3d p_world = x.p_world(x.landmarks[static_cast<std::size_t>(s.index)]);
    points.push_back(
        {.p_world = x.nav_T_world ? *x.nav_T_world * p_world : p_world, .view = s.view});
  }
  const auto place = find_place(points, nav_T_camera(0).p, *prior_->map);
  if (!place) return;
  ++place_counts_.proposed;
  prior_->nav_T_map = place->world_T_map;
  compatible_.clear();
  for (std::size_t i = 0; i < prior_->map->points.size(); ++i) {
    const MapPoint& point = prior_->map->points[i];
    prior_->points[kFirstMapId + static_cast<LandmarkId>(i)] = {
        .number = static_cast<int>(i),
        .p_nav = place->world_T_map * point.p_map,
        .appearance = point.appearance.turned(place->world_T_map.R)};
  }
}

// The map's landmarks become past landmarks of the filter.
void InertialSlam::place_map() {
  const auto all = indices_of(prior_->map->points.size());
  map_frame_ = filter_.add_past(
      placed(*prior_->map, all, *prior_->nav_T_map, kHeadingSigma, kPositionSigma));
  for (auto& [id, point] : prior_->points) point.number += *map_frame_ + 1;
  dormant_.merge(prior_->points);
}

InertialSlam::KnownLandmarks InertialSlam::known_points(
    const std::vector<Candidate>& candidates) const {
  std::vector<int> points;
  for (const Candidate& c : candidates) points.push_back(c.dormant->number);
  const PriorMap known =
      placed(*prior_->map, points, *prior_->nav_T_map, kHeadingSigma, kPositionSigma);
  const auto k = 3 * static_cast<Index>(points.size());
  return {.landmarks = known.landmarks,
          .C = MatrixXd::Zero(k, filter_.covariance().rows()),
          .P = known.covariance.bottomRightCorner(k, k)};
}

std::optional<SE3> InertialSlam::nav_T_map() const {
  if (!map_frame_) return std::nullopt;
  return filter_.joint_map(map_frame_, {}, {}).map_T_prior;
}

std::optional<PoseInMap> InertialSlam::pose_in_map(const NavState& now) const {
  if (!map_frame_) return std::nullopt;
  const Carried frame = filter_.recall(std::array{*map_frame_});
  const SE3 nav_T_map = corrected({.map_T_imu = filter_.past().frame(*map_frame_)},
                                  frame.correction, Matrix6d::Zero())
                            .map_T_imu;
  // The errors of the frame and of the pose in nav.
  const MatrixXd pose = work_.nav.derivative.topRows<6>();
  Eigen::Matrix<double, 12, 12> P;
  P.topLeftCorner<6, 6>() = frame.P;
  P.bottomRightCorner<6, 6>() = now.covariance.topLeftCorner<6, 6>();
  P.topRightCorner<6, 6>() = frame.C.leftCols(pose.cols()) * pose.transpose();
  P.bottomLeftCorner<6, 6>() = P.topRightCorner<6, 6>().transpose();
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

// The landmarks of the map first, so that its own give way where both cover a place.
LandmarkMap InertialSlam::landmark_map() const {
  struct Source {
    LandmarkId id = 0;
    Appearance appearance;  // in the map's axes
    int number = 0, index = 0;
  };
  const SE3 map_T_nav = nav_T_map().value_or(SE3{}).inverse();
  SpatialChoice choice(settings_.recognisable);
  std::vector<Source> past, present;
  const State& x = filter_.state();
  const auto choose = [&](LandmarkId id, const Vector3d& p_nav, const Appearance& appearance) {
    if (appearance.empty()) return false;
    const PatchView& view = appearance.views().front();
    return choice.choose(id, map_T_nav * p_nav, view.distance(), view.from);
  };
  for (const bool of_map : {true, false}) {
    for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
      const Landmark& landmark = x.landmarks[i];
      const auto known = appearances_.find(landmark.id);
      if ((landmark.id >= kFirstMapId) != of_map || known == appearances_.end() ||
          landmark.anchor || landmark.observations < kLeastObservations) {
        continue;
      }
      const Vector3d p_nav = x.nav_T_world ? *x.nav_T_world * landmark.p_world : landmark.p_world;
      const Appearance appearance = known->second.turned(map_T_nav.R);
      if (choose(landmark.id, p_nav, appearance)) {
        present.push_back(
            {.id = landmark.id, .appearance = appearance, .index = static_cast<int>(i)});
      }
    }
    for (const auto& [id, dormant] : dormant_) {
      if ((id >= kFirstMapId) != of_map) continue;
      const Appearance appearance = dormant.appearance.turned(map_T_nav.R);
      if (choose(id, dormant.p_nav, appearance)) {
        past.push_back({.id = id, .appearance = appearance, .number = dormant.number});
      }
    }
  }
  const std::vector<LandmarkId> dropped = choice.thin();
  const auto is_dropped = [&](const Source& source) {
    return std::ranges::find(dropped, source.id) != dropped.end();
  };
  std::erase_if(past, is_dropped);
  std::erase_if(present, is_dropped);
  std::ranges::sort(past, {}, &Source::number);
  std::ranges::sort(present, {}, &Source::index);
  std::vector<int> numbers, indices;
  for (const Source& source : past) numbers.push_back(source.number);
  for (const Source& source : present) indices.push_back(source.index);

  const PriorMap joint = filter_.joint_map(map_frame_, numbers, indices);
  const auto n = static_cast<Index>(joint.landmarks.size());
  LandmarkMap map;
  if (placed_map_) map.sessions = placed_map_->sessions;
  const auto own_session = static_cast<int>(map.sessions.size());
  map.sessions.push_back({.name = {}, .begin = {}, .end = clock(now_), .cameras = cameras_});
  past.insert(past.end(), present.begin(), present.end());
  for (std::size_t i = 0; i < past.size(); ++i) {
    const Landmark& landmark = joint.landmarks[i];
    const bool of_map = past[i].id >= kFirstMapId;
    const auto in_map = static_cast<std::size_t>(past[i].id - kFirstMapId);
    map.points.push_back({.p_map = map_T_nav * landmark.p_world,
                          .session = of_map ? placed_map_->points[in_map].session : own_session,
                          .observations = landmark.observations,
                          .appearance = std::move(past[i].appearance)});
  }
  // In the frame of the map: relative to it.
  const Index frame = joint.covariance.rows() - 3 * n;
  MatrixXd P = joint.covariance;
  if (frame > 0) {
    const Matrix3d& R = map_T_nav.R;
    MatrixXd J = MatrixXd::Zero(3 * n, frame);
    for (Index i = 0; i < n; ++i) {
      const Vector3d arm =
          joint.landmarks[static_cast<std::size_t>(i)].p_world - joint.map_T_prior.p;
      J.block<3, 3>(3 * i, 0) = hat(arm);
      J.block<3, 3>(3 * i, 3) = -Matrix3d::Identity();
    }
    const MatrixXd J_transposed = J.transpose();
    const MatrixXd cross = dense::product(J, joint.covariance.topRightCorner(frame, 3 * n));
    P = joint.covariance.bottomRightCorner(3 * n, 3 * n) + cross + cross.transpose() +
        dense::product(J,
                       dense::product(joint.covariance.topLeftCorner(frame, frame), J_transposed));
    for (Index i = 0; i < n; ++i) P.middleRows<3>(3 * i) = (R * P.middleRows<3>(3 * i)).eval();
    for (Index i = 0; i < n; ++i) {
      P.middleCols<3>(3 * i) = (P.middleCols<3>(3 * i) * R.transpose()).eval();
    }
  }
  map.covariance = JointCovariance::compressed(P);
  return map;
}

}  // namespace chasles
