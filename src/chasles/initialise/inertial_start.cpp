#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <chasles/initialise/inertial_start.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// Sigma of a place that is not known at all [m]. With more, after a pause of a day, the filter's
// arithmetic has too few digits.
constexpr double kUnknownPlace = 500;

double heading(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); }

}  // namespace

InertialStart turned(InertialStart start, double angle) {
  const Eigen::Matrix3d turn = so3::exp({0, 0, angle});
  start.nav_T_imu.R = turn * start.nav_T_imu.R;
  start.v_nav = turn * start.v_nav;
  if (!start.covariance) return start;
  for (const int row : {0, 3, 6}) {
    if (start.by_imu.size() > 0) {
      start.by_imu.middleRows<3>(row) = (turn * start.by_imu.middleRows<3>(row)).eval();
    }
    start.covariance->middleRows<3>(row) = (turn * start.covariance->middleRows<3>(row)).eval();
    start.covariance->middleCols<3>(row) =
        (start.covariance->middleCols<3>(row) * turn.transpose()).eval();
  }
  return start;
}

double camera_heading(const Eigen::Matrix3d& nav_R_imu, const Camera& camera) {
  const Eigen::Matrix3d nav_R_cam = nav_R_imu * camera.cam_T_imu.R.transpose();
  const Eigen::Vector3d optical_axis = nav_R_cam.col(2), top = -nav_R_cam.col(1);
  Eigen::Vector3d direction = optical_axis;
  if (std::abs(optical_axis.z()) > std::numbers::sqrt2 / 2)
    direction = optical_axis.z() < 0 ? top : -top;
  return std::atan2(direction.y(), direction.x());
}

// An error of the heading turns the velocity as well.
InertialStart placed(InertialStart start, const InitialiserSettings& settings,
                     const Camera& camera) {
  start.nav_T_imu.p +=
      Eigen::Vector3d(settings.position_x, settings.position_y, settings.position_z);
  if (settings.position_sigma > 0) {
    start.covariance = start.covariance.value_or(Matrix15d::Zero());
    start.covariance->block<3, 3>(3, 3).diagonal().array() +=
        settings.position_sigma * settings.position_sigma;
  }
  if (!settings.heading) return start;
  const double turn = *settings.heading - camera_heading(start.nav_T_imu.R, camera);
  start = turned(std::move(start), turn);
  Eigen::Matrix<double, 15, 1> by_heading = Eigen::Matrix<double, 15, 1>::Zero();
  by_heading(2) = 1;
  by_heading.segment<3>(6) = hat(Eigen::Vector3d::UnitZ()) * start.v_nav;
  start.covariance =
      start.covariance.value_or(Matrix15d::Zero()) +
      settings.heading_sigma * settings.heading_sigma * by_heading * by_heading.transpose();
  return start;
}

InertialStart continued(InertialStart start, const Estimate& before) {
  const double turn = heading(before.world_T_imu.R) - heading(start.nav_T_imu.R);
  start = turned(std::move(start), turn);
  start.calibration = before.calibration;
  start.nav_T_imu.p = before.world_T_imu.p;
  const double gap = to_seconds(start.time - before.time);
  const double speed = std::max({1.0, before.v_world->norm(), start.v_nav.norm()});
  const double way = std::min(speed * gap, kUnknownPlace);
  Matrix15d P = start.covariance.value_or(Matrix15d::Zero());
  P.block<3, 3>(3, 3) = before.covariance.block<3, 3>(3, 3);
  P.block<3, 3>(3, 3).diagonal().array() += way * way;
  P(2, 2) += before.covariance(2, 2) + std::min(gap * gap, M_PI * M_PI);  // 1 rad/s
  start.covariance = P;
  return start;
}

}  // namespace chasles
