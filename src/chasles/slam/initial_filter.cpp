#include <chasles/filter/dense.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/initial_filter.hpp>
#include <chasles/slam/start_covariance.hpp>

namespace chasles {
namespace {

State initial_state(const InertialSlamSettings& s, const InertialStart& start,
                    const std::optional<Calibration>& calibration) {
  State x;
  if (calibration) {
    x.imu_T_camera = calibration->imu_T_camera;
    x.time_offset = calibration->time_offset;
    x.intrinsics = calibration->intrinsics;
    x.imu = calibration->imu;
  }
  x.additive.resize(InertialModel::kSize);
  x.additive << start.accelerometer_bias, start.gyroscope_bias;
  if (s.nav_attitude) {
    x.nav_T_world = start.nav_T_imu;
    x.v_world = start.nav_T_imu.R.transpose() * start.v_nav;
  } else {
    x.world_T_imu = start.nav_T_imu;
    x.v_world = start.v_nav;
  }
  return x;
}

// From errors in nav to those of the state's core.
Eigen::MatrixXd initial_covariance(const InertialSlamSettings& s, const InertialStart& start,
                                   const State& x, const std::optional<Calibration>& calibration) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(x.core_size(), 15);
  J.block<3, 3>(x.nav_T_world ? x.nav_row() : 0, 0).setIdentity();
  J.block<3, 3>(x.nav_T_world ? x.nav_row() + 3 : 3, 3).setIdentity();
  J.block<3, 3>(6, 6).setIdentity();
  J.block<6, 6>(x.additive_row(), 9).setIdentity();
  if (x.nav_T_world) {  // v_world = R^T v_nav, R = Exp(psi) Rhat
    const Eigen::Matrix3d& R = x.nav_T_world->R;
    J.block<3, 3>(6, 6) = R.transpose();
    J.block<3, 3>(6, 0) = R.transpose() * hat(start.v_nav);
  }
  Eigen::MatrixXd P = dense::product(J, dense::product(start_covariance(s, start), J.transpose()));
  const int n = x.calibration_size();
  if (calibration) P.bottomRightCorner(n, n) = calibration->covariance;
  if (x.imu && start.by_imu.size() > 0) {
    const Eigen::MatrixXd by_imu = J * start.by_imu;
    const Eigen::MatrixXd more = by_imu * calibration->covariance.bottomRows(x.imu->size());
    P += by_imu * calibration->covariance.bottomRightCorner(x.imu->size(), x.imu->size()) *
         by_imu.transpose();
    P.rightCols(n) += more;
    P.bottomRows(n) += more.transpose();
  }
  return P;
}

}  // namespace

bool keeps_past(const InertialSlamSettings& s) {
  return s.keeps_exact_map() || s.recognise != Recognise::kNone;
}

Ekf initial_filter(const InertialSlamSettings& s, const InertialStart& start,
                   std::span<const Camera> cameras) {
  const auto calibration = start.calibration ? start.calibration : stated_calibration(s, cameras);
  const State x = initial_state(s, start, calibration);
  return {error_chart(s.chart),
          x,
          initial_covariance(s, start, x, calibration),
          {.map = keeps_past(s) ? Ekf::Map::kPast : Ekf::Map::kFrozen,
           .past = {.recalls = s.recognise != Recognise::kNone,
                    .records = true,
                    .most_bytes = static_cast<std::size_t>(1e6 * s.map_memory)},
           .keep_scale = s.keep_scale == Toggle::kTrue,
           .considered = considered_rows(s, x)}};
}

}  // namespace chasles
