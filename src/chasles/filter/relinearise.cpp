#include <algorithm>

#include <chasles/filter/relinearise.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

// T(y)^-1 T(x) of a pose.
Matrix6d change_of_pose(const ErrorChart& chart, const SE3& x, const SE3& y) {
  return solve(pose_block(chart, y), pose_block(chart, x));
}

}  // namespace

Eigen::VectorXd correction_between(const ErrorChart& chart, const State& x, const State& y) {
  Eigen::VectorXd correction = local(chart, x, y);
  pull(chart, x, correction);
  return correction;
}

void refer_to(const ErrorChart& chart, const State& x, const State& y,
              const Eigen::VectorXd& correction, Measurement& z) {
  if (z.core_column == 0 && z.d_core.cols() >= 6) {
    z.d_core.leftCols<6>() *= change_of_pose(chart, x.world_T_imu, y.world_T_imu);
  }
  for (Measurement::OfClone& of_clone : z.clones) {
    const auto same_row = [&](const Clone& clone) { return clone.row == of_clone.row; };
    const auto clone = std::ranges::find_if(x.clones, same_row);
    if (clone != x.clones.end()) {
      const auto there = y.clones.begin() + (clone - x.clones.begin());
      of_clone.d *= change_of_pose(chart, clone->world_T_imu, there->world_T_imu);
    }
    z.residual += of_clone.d * correction.segment<6>(of_clone.row);
  }
  if (z.landmark >= 0) {
    const auto index = static_cast<std::size_t>(z.landmark);
    const Landmark& landmark = x.landmarks[index];
    if (chart.landmark_block && !landmark.anchor) {
      z.d_core.leftCols<3>() += z.d_landmark * (chart.landmark_block(landmark.p_world) -
                                                chart.landmark_block(y.landmarks[index].p_world));
    }
    z.residual += z.d_landmark * correction.segment<3>(landmark.row);
  }
  z.residual += z.d_core * correction.segment(z.core_column, z.d_core.cols());
}

}  // namespace chasles
