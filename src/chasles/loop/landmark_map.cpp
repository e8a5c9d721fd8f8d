#include <Eigen/Geometry>

#include <chasles/loop/landmark_map.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

PriorMap placed(const LandmarkMap& map, std::span<const int> points, const MapPlace& place) {
  const SE3& world_T_map = place.world_T_map;
  const Matrix3d& R = world_T_map.R;
  const auto n = static_cast<Index>(points.size());
  const Index r = map.covariance.rank();
  PriorMap prior{.map_T_prior = world_T_map,
                 .landmarks = {},
                 .shared = Eigen::MatrixXd::Zero(6 + 3 * n, r + 4),
                 .own = {},
                 .of_frame = 4};
  const auto moved_by_place = [&](const Vector3d& p_world) {
    Eigen::Matrix<double, 3, 4> by;
    by << place.heading_sigma * Vector3d::UnitZ().cross(p_world - place.pivot),
        place.position_sigma * Matrix3d::Identity();
    return by;
  };
  prior.shared(2, r) = place.heading_sigma;
  prior.shared.block<3, 4>(3, r) = moved_by_place(world_T_map.p);
  for (Index i = 0; i < n; ++i) {
    const int index = points[static_cast<std::size_t>(i)];
    const MapPoint& point = map.points[static_cast<std::size_t>(index)];
    const Vector3d p_world = world_T_map * point.p_map;
    prior.landmarks.push_back({.id = kFirstMapId + index,
                               .p_world = p_world,
                               .observations = point.observations,
                               .first = p_world});
    auto rows = prior.shared.middleRows<3>(6 + 3 * i);
    rows.leftCols(r) = R * map.covariance.shared().middleRows<3>(3 * static_cast<Index>(index));
    rows.rightCols<4>() = moved_by_place(p_world);
    prior.own.emplace_back(R * map.covariance.own()[static_cast<std::size_t>(index)] *
                           R.transpose());
  }
  return prior;
}

}  // namespace chasles
