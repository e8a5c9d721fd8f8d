#include <chasles/map/landmark_map.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

PriorMap placed(const LandmarkMap& map, std::span<const int> points, const SE3& world_T_map,
                double heading_sigma, double position_sigma) {
  const Matrix3d& R = world_T_map.R;
  const auto n = static_cast<Index>(points.size());
  const Index r = map.covariance.rank();
  PriorMap prior{.map_T_prior = world_T_map,
                 .landmarks = {},
                 .shared = Eigen::MatrixXd::Zero(6 + 3 * n, r + 4),
                 .own = {}};
  // The last four: the errors of the heading and of the position.
  prior.shared(2, r) = heading_sigma;
  prior.shared.block<3, 3>(3, r + 1) = position_sigma * Matrix3d::Identity();
  for (Index i = 0; i < n; ++i) {
    const int index = points[static_cast<std::size_t>(i)];
    const MapPoint& point = map.points[static_cast<std::size_t>(index)];
    const Vector3d arm = R * point.p_map, p_world = arm + world_T_map.p;
    prior.landmarks.push_back({.id = kFirstMapId + index,
                               .p_world = p_world,
                               .observations = point.observations,
                               .first = p_world});
    auto rows = prior.shared.middleRows<3>(6 + 3 * i);
    rows.leftCols(r) = R * map.covariance.shared().middleRows<3>(3 * static_cast<Index>(index));
    rows.col(r) = heading_sigma * Vector3d::UnitZ().cross(arm);
    rows.rightCols<3>() = position_sigma * Matrix3d::Identity();
    prior.own.emplace_back(R * map.covariance.own()[static_cast<std::size_t>(index)] *
                           R.transpose());
  }
  return prior;
}

}  // namespace chasles
