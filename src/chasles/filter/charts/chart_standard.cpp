#include <chasles/filter/charts/chart_detail.hpp>

namespace chasles {
namespace {
namespace standard {

using namespace chart_detail;

void retract(State& x, const ErrorRef& xi) {
  const Eigen::Vector3d theta = xi.head<3>();
  x.world_T_imu.R = so3::exp(theta) * x.world_T_imu.R;
  x.world_T_imu.p += xi.segment<3>(3);
  if (x.v_world) *x.v_world += xi.segment<3>(6);
  add_additive(x, xi);
  add_landmarks(x, xi);
}

Eigen::VectorXd local(const State& x, const State& y) {
  Eigen::VectorXd xi = differences(x, y);
  xi.head<3>() = so3::log(y.world_T_imu.R * x.world_T_imu.R.transpose());
  return xi;
}

MotionBlock motion_block(const State&) { return MotionBlock::Identity(); }

}  // namespace standard
}  // namespace

const ErrorChart kStandardChart{
    .name = "standard",
    .summary = "rotation in world axes; position, velocity and landmarks additive",
    .retract = standard::retract,
    .local = standard::local,
    .motion_block = standard::motion_block,
    .landmark_block = nullptr,
};

}  // namespace chasles
