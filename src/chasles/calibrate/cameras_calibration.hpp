#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/lens_parameters.hpp>
#include <chasles/calibrate/target_shape.hpp>

namespace chasles {

/// Views of a target by the cameras of a rig. Target and rig may both move: what cameras see at the
/// same instant has one pose of the target.
struct CamerasInput {
  std::vector<Eigen::Vector3d> corners;  ///< p_target, as Target::corners() [m]
  std::vector<TargetView> views;         ///< in any order
  /// The size of the images of each camera; with fx > 0 also from where the search begins. Without,
  /// it begins from nothing.
  std::vector<Camera> cameras;
  std::vector<LensForm> lenses;  ///< of each camera
  TargetShape shape = {};        ///< what of the target is estimated
};

/// The rows of a calibration's parameters: of each camera (fx, fy, cx, cy, coefficients) and, for
/// those after the first, the errors of cam_T_cam0: R = Exp(phi) Rhat and p = phat + dp, in the
/// axes of the camera [rad, m]; at last those of the target's shape.
class CamerasLayout {
 public:
  explicit CamerasLayout(const std::vector<LensForm>& lenses,
                         std::vector<std::string> shape_names = {});

  int lens_row(std::size_t camera) const { return first_[camera]; }
  int pose_row(std::size_t camera) const { return first_[camera] + lenses_[camera].parameters(); }
  int shape_row() const { return first_.back(); }
  int shape_rows() const { return static_cast<int>(shape_names_.size()); }
  int rows() const { return shape_row() + shape_rows(); }
  const LensForm& lens(std::size_t camera) const { return lenses_[camera]; }
  std::vector<std::string> names() const;  ///< "cam0.fx", "cam1.rotation_x", "cam1.position_x", …

 private:
  std::vector<LensForm> lenses_;
  std::vector<int> first_;
  std::vector<std::string> shape_names_;
};

/// A view as a calibration explains it.
struct ExplainedView {
  TargetView view;
  SE3 cam_T_target;
  std::vector<Eigen::Vector2d> errors;  ///< measured minus projected corners [px]
  double rms = 0;                       ///< of them [px]
};

struct CamerasCalibration {
  std::vector<Camera> cameras;           ///< cam_T_imu is cam_T_cam0
  std::vector<LensForm> lenses;          ///< of them
  std::vector<std::string> shape_names;  ///< TargetShape::names
  Eigen::VectorXd shape;                 ///< of the target, by its names
  CamerasLayout layout() const { return CamerasLayout(lenses, shape_names); }
  Eigen::MatrixXd covariance;  ///< of the parameters, as layout()
  double pixel_sigma = 0;      ///< of a corner's u or v, robust [px]
  int pieces = 0;              ///< of views with independent errors
  /// By how much the variances are larger than those of errors that are independent from corner to
  /// corner: estimated from the scatter of what each second of views says. At least 1.
  double correlation_factor = 1;
  std::vector<ExplainedView> views;  ///< by time and camera
  std::size_t without_pose = 0;      ///< views that were not used: fewer than 4 corners, or no pose
  int iterations = 0;
};

/// Views that do not determine all parameters of the lenses.
class UndeterminedError : public InputError {
 public:
  using InputError::InputError;
};

/// Throws InputError or UsageError, beginning with `caller`, for a view that these cameras and this
/// target cannot have.
void check_view(const CamerasInput& input, const TargetView& view, const std::string& caller);

/// Least squares of the corners' pixels, under Huber's loss at three standard deviations; no corner
/// is left out. Throws UndeterminedError where the views do not determine the parameters and where
/// the search does not converge, and InputError where cameras share no instants: with what is
/// missing.
CamerasCalibration calibrate_cameras(const CamerasInput& input);

}  // namespace chasles
