#pragma once

#include <optional>

#include <ceres/cost_function.h>

#include <chasles/camera/stereo.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>
#include <chasles/smooth/terms/twist_link.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

/// The terms of a recording with body velocities, over blocks motion (12 numbers: a pose), additive
/// (as many as the model has; omitted where it has none) and point (3).
namespace chasles::smooth_detail {

/// An observation of a landmark by a rectified pair: as velocity/stereo_measurement.hpp, for points
/// at any distance. The anchor of a landmark is the left camera.
template <int Rows>
struct StereoTerm {
  static constexpr int kRows = Rows, kNumbers = kPoseNumbers;
  const StereoRig* rig = nullptr;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
  Eigen::Matrix<double, Rows, 4> whitened_rows = Eigen::Matrix<double, Rows, 4>::Zero();
  double least_depth = kLeastDepth;

  std::optional<PredictedView<Rows>> see(const SE3& world_T_imu,
                                         const HomogeneousPoint& point) const;
  const SE3& anchor_cam_T_imu() const { return rig->cam0_T_imu; }
};

/// The term with these rows; their number must be `Rows`.
template <int Rows>
StereoTerm<Rows> stereo_term(const StereoRig& rig, StereoRows rows, const StereoNoise& noise,
                             const Eigen::Vector4d& pixels);

/// The prior at the start. Blocks: motion, additive.
struct VelocityStart {
  VelocityState mean;
  Eigen::MatrixXd whitening;  ///< of [rotation, position, additive], reference chart
};
class VelocityStartCost final : public ceres::CostFunction {
 public:
  explicit VelocityStartCost(const VelocityStart& start);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const VelocityStart* start_;
};

/// Blocks: motion, additive of a keyframe; of the next.
class TwistCost final : public ceres::CostFunction {
 public:
  explicit TwistCost(const TwistLink& link);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const TwistLink* link_;
};

/// A sample that measures the velocity state. Blocks: motion, where the samples' axes are level;
/// additive.
struct VelocitySample {
  int keyframe = 0;
  BodyVelocity velocity;
  BodyVelocityNoise noise;
};
class SampleCost final : public ceres::CostFunction {
 public:
  SampleCost(const BodyVelocityModel& model, const VelocitySample& sample);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  BodyVelocityModel model_;
  const VelocitySample* sample_;
};

}  // namespace chasles::smooth_detail
