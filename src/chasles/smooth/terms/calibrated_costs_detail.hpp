#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <ceres/cost_function.h>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

/// The terms of the cost where the calibration is estimated. Private to the smooth folder.
namespace chasles::smooth_detail {

using Matrix26d = Eigen::Matrix<double, 2, 6>;

/// The prior of a calibration. Blocks: all CalibrationBlocks. Jacobians of a pose have the
/// derivatives by its six errors in their first columns.
class CalibrationCost final : public ceres::CostFunction {
 public:
  /// `whitening`: W^T W = covariance^-1.
  CalibrationCost(const Calibration& mean, const Eigen::MatrixXd& whitening);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  CalibrationBlocks blocks_;
  std::vector<double> mean_;
  Eigen::MatrixXd whitening_;
};

/// The start, whose errors depend on those of the IMU's parameters (InertialStart::by_imu). Blocks:
/// motion, biases of the first keyframe; the IMU's parameters.
class CorrectedStartCost final : public ceres::CostFunction {
 public:
  explicit CorrectedStartCost(const BatchGraph& graph);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const BatchGraph* graph_;
};

/// A link by samples that the IMU's parameters correct. Blocks: motion, biases of a keyframe; of
/// the next; the IMU's parameters.
class CorrectedLinkCost final : public ceres::CostFunction {
 public:
  /// `like`: with the parameters that are estimated.
  CorrectedLinkCost(const ImuLink& measured, const Eigen::Vector3d& gravity,
                    const ImuCorrection& like);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const ImuLink* measured_;
  Eigen::Vector3d gravity_;
  ImuCorrection like_;
};

/// The terms of the start and of a link of the graph, to which they point. They depend on the
/// IMU's parameters, as their last block, where the graph has CalibrationBlocks::of_imu, and where
/// the start depends on them.
std::unique_ptr<ceres::CostFunction> start_cost(const BatchGraph& graph);
std::unique_ptr<ceres::CostFunction> link_cost(const BatchGraph& graph, const ImuLink& link);

/// The camera of a pixel, some of whose parameters are estimated.
struct EstimatedCamera {
  Camera camera = {};           ///< the known ones, and the size of its images
  bool has_extrinsics = false;  ///< that are estimated
  /// By which the times of the keyframes were chosen [s], if it is estimated.
  std::optional<double> time_offset = {};
  std::optional<Intrinsics> intrinsics = {};  ///< that are estimated

  /// The camera of `index` in a calibration that is estimated.
  EstimatedCamera(const Camera& camera, int index, const Calibration& calibration,
                  double time_offset);
};

/// Axes of an anchored landmark that move with the estimated extrinsics of a camera.
struct AnchorCamera {
  AnchorFace face = AnchorFace::kFront;
  SE3 imu_T_line = {};  ///< of the pixel that anchored it
  bool is_view = true;  ///< whether it is the camera of the view, too

  SE3 axes_T_imu(const SE3& imu_T_camera) const {
    return face_T_imu(face, (imu_T_line * imu_T_camera).inverse());
  }
};

/// A pixel observation of a landmark by such a camera. The image was taken when the camera's clock
/// says so: later than the keyframe's time by the change of the time offset.
struct CalibratedTerm {
  EstimatedCamera camera;
  ReadoutMotion motion = {};  ///< after the keyframe of the view
  SE3 of_anchor = {};         ///< of an anchored landmark: axes that are fixed to its keyframe
  std::optional<AnchorCamera> anchor = {};  ///< and where they are not
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1;
  double least_depth = kLeastDepth;
};

/// That of a view, where the graph's calibration is estimated. `of_anchor`: anchor_T_imu of its
/// landmark; `sigma`: sigma_of the view.
CalibratedTerm calibrated_term(const InertialBatchInput& input, const BatchGraph& graph,
                               const PointView& view, const SE3& of_anchor, double sigma);

/// Its residual. Blocks: those of PointCost, AnchoredCost or AnchorCost, the
/// CalibrationBlocks::of_camera, and the extrinsics of an AnchorCamera that is not the view's.
class CalibratedCost final : public ceres::CostFunction {
 public:
  CalibratedCost(CalibratedTerm term, ViewForm form);
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  struct At;  // the camera at the line of the pixel
  At at(const double* const* calibration) const;
  void write_calibration(const At& at, const SE3& world_T_imu, const HomogeneousPoint& point,
                         const Seen& seen, const Matrix26d& by_anchor, double** jacobians) const;
  Landmark anchored(const double* parameters, const double* const* calibration) const;

  CalibratedTerm term_;
  ViewForm form_;
};

}  // namespace chasles::smooth_detail
