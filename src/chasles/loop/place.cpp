#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <chasles/lie/so3.hpp>
#include <chasles/loop/place.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

// Of 256 comparisons, 128 differ by chance.
constexpr int kAlike = 60;
constexpr std::size_t kMostEach = 3, kMostProposals = 150;
constexpr int kLeastAgreeing = 6;
// The direction to a point, as seen from the camera [rad]: for a place from two points, and for one
// from all that agree; and the factor between its expected and its estimated distance.
constexpr double kRoughly = 0.06, kClosely = 0.02, kDistanceFactor = 1.35;
// Two points give the heading by the line between them: this part of their distance from the
// camera.
constexpr double kLeastBase = 0.15;
// Elevation of two views of a point, as the sine's difference.
constexpr float kSameElevation = 0.4F;

struct Proposal {
  PlaceInMap::Match match;
  int distance = 0;
};

// For each point that is seen, those of the map that look most like it.
std::vector<Proposal> similar_points(std::span<const PlacePoint> seen, const LandmarkMap& map) {
  std::vector<Proposal> proposals;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const PatchView& view = seen[i].view;
    std::vector<Proposal> alike;
    for (std::size_t k = 0; k < map.points.size(); ++k) {
      int least = kAlike + 1;
      for (const PatchView& of_map : map.points[k].appearance.views()) {
        if (std::abs(of_map.from.z() - view.from.z()) > kSameElevation) continue;
        if (const auto d = distance(of_map, view)) least = std::min(least, *d);
      }
      if (least > kAlike) continue;
      alike.push_back({{static_cast<int>(i), static_cast<int>(k)}, least});
    }
    std::ranges::stable_sort(alike, {}, &Proposal::distance);
    if (alike.size() > kMostEach) alike.resize(kMostEach);
    proposals.insert(proposals.end(), alike.begin(), alike.end());
  }
  std::ranges::stable_sort(proposals, {}, &Proposal::distance);
  if (proposals.size() > kMostProposals) proposals.resize(kMostProposals);
  return proposals;
}

class PlaceSearch {
 public:
  PlaceSearch(std::span<const PlacePoint> seen, Vector3d p_camera, const LandmarkMap& map)
      : seen_(seen), p_camera_(std::move(p_camera)), map_(map) {
    for (const Proposal& proposal : similar_points(seen, map)) {
      matches_.push_back(proposal.match);
    }
  }

  std::optional<PlaceInMap> result() const {
    SE3 best;
    std::vector<int> most;
    std::vector<std::vector<int>> others;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      for (std::size_t j = i + 1; j < matches_.size(); ++j) {
        const auto place = from_two(matches_[i], matches_[j]);
        if (!place) continue;
        std::vector<int> agreeing = agree(*place, kRoughly);
        if (agreeing.size() < 3) continue;
        others.push_back(agreeing);
        if (agreeing.size() <= most.size()) continue;
        const SE3 refined = refine(*place, agreeing);
        std::vector<int> closely = agree(refined, kClosely);
        if (closely.size() <= most.size()) continue;
        best = refine(refined, closely);
        most = agree(best, kClosely);
      }
    }
    if (static_cast<int>(most.size()) < kLeastAgreeing) return std::nullopt;
    for (const std::vector<int>& other : others) {
      const bool elsewhere = std::ranges::none_of(
          other, [&](int i) { return std::ranges::find(most, i) != most.end(); });
      if (elsewhere && 2 * other.size() > most.size()) return std::nullopt;
    }
    PlaceInMap place{.world_T_map = best, .matches = {}};
    for (const int i : most) place.matches.push_back(matches_[static_cast<std::size_t>(i)]);
    return place;
  }

 private:
  const Vector3d& world(const PlaceInMap::Match& match) const {
    return seen_[static_cast<std::size_t>(match.seen)].p_world;
  }
  const Vector3d& in_map(const PlaceInMap::Match& match) const {
    return map_.points[static_cast<std::size_t>(match.point)].p_map;
  }

  // The line between two points gives the heading, their middle the position.
  std::optional<SE3> from_two(const PlaceInMap::Match& a, const PlaceInMap::Match& b) const {
    if (a.seen == b.seen || a.point == b.point) return std::nullopt;
    const Vector3d in_world = world(b) - world(a), of_map = in_map(b) - in_map(a);
    const double far = std::max((world(a) - p_camera_).norm(), (world(b) - p_camera_).norm());
    const double length = in_world.head<2>().norm(), expected = of_map.head<2>().norm();
    const double slack = (kDistanceFactor - 1) * far;
    if (length < kLeastBase * far || expected < kLeastBase * far ||
        std::abs(length - expected) > slack || std::abs(in_world.z() - of_map.z()) > slack) {
      return std::nullopt;
    }
    const double turn = std::atan2(in_world.y(), in_world.x()) - std::atan2(of_map.y(), of_map.x());
    SE3 place;
    place.R = so3::exp({0, 0, turn});
    place.p = (world(a) + world(b)) / 2 - place.R * (in_map(a) + in_map(b)) / 2;
    return place;
  }

  // Matches that agree with a place: the best of each point that is seen, and of each of the map.
  std::vector<int> agree(const SE3& place, double angle) const {
    std::vector<std::pair<double, int>> by_error;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      const Vector3d seen = world(matches_[i]) - p_camera_;
      const Vector3d expected = place * in_map(matches_[i]) - p_camera_;
      const double factor = expected.norm() / seen.norm();
      if (!(factor < kDistanceFactor && factor > 1 / kDistanceFactor)) continue;
      const double error = (expected.normalized() - seen.normalized()).norm();
      if (error < angle) by_error.emplace_back(error, static_cast<int>(i));
    }
    std::ranges::sort(by_error);
    std::vector<int> agreeing;
    for (const auto& [error, i] : by_error) {
      const PlaceInMap::Match& match = matches_[static_cast<std::size_t>(i)];
      const bool taken = std::ranges::any_of(agreeing, [&](int k) {
        const PlaceInMap::Match& other = matches_[static_cast<std::size_t>(k)];
        return other.seen == match.seen || other.point == match.point;
      });
      if (!taken) agreeing.push_back(i);
    }
    return agreeing;
  }

  // Least squares of the directions, and weakly of the distances: Gauss-Newton.
  SE3 refine(SE3 place, const std::vector<int>& agreeing) const {
    constexpr int kSteps = 4;
    constexpr double kDistanceWeight = 0.1;  // sigma of a direction by that of a relative distance
    for (int step = 0; step < kSteps; ++step) {
      Eigen::Matrix4d A = 1e-9 * Eigen::Matrix4d::Identity();
      Eigen::Vector4d b = Eigen::Vector4d::Zero();
      for (const int i : agreeing) {
        const PlaceInMap::Match& match = matches_[static_cast<std::size_t>(i)];
        const Vector3d arm = place.R * in_map(match);
        const Vector3d expected = arm + place.p - p_camera_, seen = world(match) - p_camera_;
        const double d = expected.norm();
        const Vector3d e = expected / d;
        Eigen::Matrix<double, 3, 4> move;
        move << Vector3d::UnitZ().cross(arm), Eigen::Matrix3d::Identity();
        const Eigen::Matrix<double, 3, 4> J =
            (Eigen::Matrix3d::Identity() - e * e.transpose()) * move / d;
        const Vector3d r = seen.normalized() - e;
        A += J.transpose() * J;
        b += J.transpose() * r;
        const Eigen::RowVector4d along = kDistanceWeight / d * e.transpose() * move;
        A += along.transpose() * along;
        b += along.transpose() * (kDistanceWeight * (seen.norm() / d - 1));
      }
      const Eigen::Vector4d by = A.ldlt().solve(b);
      place.R = so3::exp({0, 0, by(0)}) * place.R;
      place.p += by.tail<3>();
    }
    return place;
  }

  std::span<const PlacePoint> seen_;
  Vector3d p_camera_;
  const LandmarkMap& map_;
  std::vector<PlaceInMap::Match> matches_;
};

}  // namespace

std::optional<PlaceInMap> find_place(std::span<const PlacePoint> seen, const Vector3d& p_camera,
                                     const LandmarkMap& map) {
  return PlaceSearch(seen, p_camera, map).result();
}

}  // namespace chasles
