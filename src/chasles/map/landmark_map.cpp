#include <algorithm>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/map/landmark_map.hpp>
#include <chasles/recognise/spatial_choice.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;

// The joint covariance of the frame [rotation; position] and of some points in the world.
MatrixXd with_frame(const LandmarkMap& map, std::span<const int> points, const SE3& world_T_map,
                    double heading_sigma, double position_sigma) {
  const Matrix3d& R = world_T_map.R;
  const auto n = static_cast<Index>(points.size());
  MatrixXd P = MatrixXd::Zero(6 + 3 * n, 6 + 3 * n);
  P.bottomRightCorner(3 * n, 3 * n) = map.covariance.of(points);
  for (Index i = 0; i < n; ++i) {
    auto rows = P.block(6 + 3 * i, 6, 3, 3 * n);
    rows = (R * rows).eval();
  }
  for (Index i = 0; i < n; ++i) {
    auto columns = P.block(6, 6 + 3 * i, 3 * n, 3);
    columns = (columns * R.transpose()).eval();
  }
  MatrixXd J = MatrixXd::Zero(6 + 3 * n, 4);  // by the sigmas of heading and position
  J(2, 0) = heading_sigma;
  J.block<3, 3>(3, 1) = position_sigma * Matrix3d::Identity();
  for (Index i = 0; i < n; ++i) {
    const Eigen::Vector3d arm =
        R * map.points[static_cast<std::size_t>(points[static_cast<std::size_t>(i)])].p_map;
    J.block<3, 1>(6 + 3 * i, 0) = heading_sigma * Eigen::Vector3d::UnitZ().cross(arm);
    J.block<3, 3>(6 + 3 * i, 1) = position_sigma * Matrix3d::Identity();
  }
  const MatrixXd J_transposed = J.transpose();
  return P + dense::product(J, J_transposed);
}

}  // namespace

PriorMap placed(const LandmarkMap& map, std::span<const int> points, const SE3& world_T_map,
                double heading_sigma, double position_sigma) {
  PriorMap prior;
  prior.map_T_prior = world_T_map;
  for (const int i : points) {
    const MapPoint& point = map.points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d p_world = world_T_map * point.p_map;
    prior.landmarks.push_back({.id = kFirstMapId + i,
                               .p_world = p_world,
                               .observations = point.observations,
                               .first = p_world});
  }
  prior.covariance = with_frame(map, points, world_T_map, heading_sigma, position_sigma);
  return prior;
}

LandmarkMap thinned(const LandmarkMap& map, int most) {
  if (static_cast<int>(map.points.size()) <= most) return map;
  SpatialChoice choice(most);
  std::vector<int> kept;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const PatchView& view = map.points[i].appearance.views().front();
    const auto index = static_cast<int>(i);
    if (choice.choose(index, map.points[i].p_map, view.distance(), view.from))
      kept.push_back(index);
  }
  const std::vector<LandmarkId> dropped = choice.thin();
  std::erase_if(kept, [&](int i) { return std::ranges::find(dropped, i) != dropped.end(); });
  LandmarkMap result{.sessions = map.sessions, .points = {}, .covariance = {}};
  for (const int i : kept) result.points.push_back(map.points[static_cast<std::size_t>(i)]);
  result.covariance = map.covariance.part(kept);
  return result;
}

}  // namespace chasles
