#pragma once

#include <ceres/manifold.h>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/imu/strapdown.hpp>

/// An error chart of the filter as a Ceres manifold. Private to the smooth folder.
namespace chasles::smooth_detail {

/// A keyframe's pose and velocity as numbers: world_T_imu.R by columns, world_T_imu.p, v_world.
inline constexpr int kMotionNumbers = 15, kMotionErrors = 9;
/// The first of them: a pose alone, where the motion has no velocity in the world.
inline constexpr int kPoseNumbers = 12, kPoseErrors = 6;

void write_pose(const SE3& world_T_imu, double* x);
SE3 read_pose(const double* x);
void write_motion(const InertialState& state, double* x);
/// With the biases: six numbers besides the motion, accelerometer's, then gyroscope's.
void write_state(const InertialState& state, double* motion, double* biases);
InertialState read_state(const double* motion, const double* biases);

/// Plus and Minus are the chart's retract and local. Cost functions write derivatives by the
/// reference chart's nine errors (six of a pose) into the first columns of a block's Jacobian, and
/// zeros behind. Therefore PlusJacobian is [T(x)^-1; 0], T the chart's own block, and the product
/// is the derivative by the chart's errors. Ceres uses the two only as this product.
class ChartManifold final : public ceres::Manifold {
 public:
  explicit ChartManifold(const ErrorChart& chart, bool velocity = true)
      : chart_(&chart), velocity_(velocity) {}
  int AmbientSize() const override { return velocity_ ? kMotionNumbers : kPoseNumbers; }
  int TangentSize() const override { return velocity_ ? kMotionErrors : kPoseErrors; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  State state_of(const double* x) const;

  const ErrorChart* chart_;
  bool velocity_;  // is part of the numbers
};

}  // namespace chasles::smooth_detail
