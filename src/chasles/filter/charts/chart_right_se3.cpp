#include <chasles/filter/charts/chart_detail.hpp>

namespace chasles {
namespace {
namespace right_se3 {

using namespace chart_detail;

void retract(State& x, const ErrorRef& xi) {
  x.world_T_imu = se3::exp(xi.head<6>()) * x.world_T_imu;
  if (x.v_world) *x.v_world += xi.segment<3>(6);
  add_additive(x, xi);
  add_landmarks(x, xi);
}

Eigen::VectorXd local(const State& x, const State& y) {
  Eigen::VectorXd xi = differences(x, y);
  xi.head<6>() = se3::log(y.world_T_imu * x.world_T_imu.inverse());
  return xi;
}

MotionBlock motion_block(const State& x) {
  MotionBlock T = MotionBlock::Identity();
  T.block<3, 3>(3, 0) = hat(x.world_T_imu.p);
  return T;
}

}  // namespace right_se3
}  // namespace

const ErrorChart kRightSe3Chart{
    .name = "right-se3",
    .summary = "pose error a twist in the world frame, exp(xi) X; velocity and landmarks additive",
    .retract = right_se3::retract,
    .local = right_se3::local,
    .motion_block = right_se3::motion_block,
    .landmark_block = nullptr,
};

}  // namespace chasles
