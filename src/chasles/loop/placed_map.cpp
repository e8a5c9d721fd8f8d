#include <array>

#include <chasles/lie/so3.hpp>
#include <chasles/loop/placed_map.hpp>

namespace chasles {

// The frame of the map follows from the shared errors of its landmarks.
PlacedMap::Frame PlacedMap::frame(const Ekf& filter, const Carried& shared) const {
  const PriorMap& prior = filter.past().prior(number_);
  const Eigen::Index r = prior.shared.cols();
  Frame frame{.nav_T_map = {}, .by_shared = prior.shared.topRows<6>()};
  const Vector6d correction = frame.by_shared * shared.correction.head(r);
  frame.nav_T_map =
      corrected({.map_T_imu = prior.map_T_prior}, correction, Matrix6d::Zero()).map_T_imu;
  return frame;
}

SE3 PlacedMap::nav_T_map(const Ekf& filter) const {
  return frame(filter, filter.past().recall(std::array{number_})).nav_T_map;
}

PoseInMap PlacedMap::pose_in_map(const Ekf& filter, const NavState& now,
                                 const Eigen::MatrixXd& derivative) const {
  using Eigen::Matrix3d;
  const Carried shared = filter.past().recall(std::array{number_});
  const Frame of_map = frame(filter, shared);
  const Eigen::MatrixXd& B = of_map.by_shared;
  const Eigen::MatrixXd pose = derivative.topRows<6>();
  // The errors of the frame and of the pose in nav.
  Eigen::Matrix<double, 12, 12> P;
  P.topLeftCorner<6, 6>() = B * shared.P * B.transpose();
  P.bottomRightCorner<6, 6>() = now.covariance.topLeftCorner<6, 6>();
  P.topRightCorner<6, 6>() = B * shared.C.leftCols(pose.cols()) * pose.transpose();
  P.bottomLeftCorner<6, 6>() = P.topRightCorner<6, 6>().transpose();
  const SE3& nav_T_map = of_map.nav_T_map;
  const Matrix3d map_R_nav = nav_T_map.R.transpose();
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.block<3, 3>(0, 0) = -map_R_nav;
  J.block<3, 3>(0, 6) = map_R_nav;
  J.block<3, 3>(3, 0) = map_R_nav * hat(now.nav_T_imu.p - nav_T_map.p);
  J.block<3, 3>(3, 3) = -map_R_nav;
  J.block<3, 3>(3, 9) = map_R_nav;
  return {.map_T_imu = nav_T_map.inverse() * now.nav_T_imu,
          .covariance = J * P * J.transpose(),
          .world_T_map = nav_T_map};
}

}  // namespace chasles
