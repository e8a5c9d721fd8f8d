#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/imu/imu_correction.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/imu/strapdown.hpp>

namespace chasles {

/// Views of a static target by a moving rig with an IMU, in one recording or several. Between two
/// recordings the target may be moved, and each sensor has a bias of its own.
struct InertialCalibrationInput {
  CamerasInput cameras;  ///< a stated cam_T_imu is not used: the search begins from nothing
  std::vector<ImuSample> imu;
  /// Between each two recordings a time that parts their views and their samples (add_recording).
  std::vector<Time> borders = {};
  ImuConvention convention = ImuConvention::kInstant;
  ImuNoise noise;
  double gravity = kStandardGravity;  ///< its magnitude where the recording was made [m/s^2]
  bool has_readout = false;    ///< whether the cameras have a rolling shutter to be estimated
  bool has_imu_errors = true;  ///< whether scales and misalignments of the IMU are estimated

  std::size_t recordings() const { return borders.size() + 1; }
  std::size_t recording_of(Time time) const;
};

/// Adds the views and samples of one more recording of the same rig, by the same clocks: their
/// times come later than all that are there.
void add_recording(InertialCalibrationInput& input, std::vector<TargetView> views,
                   std::vector<ImuSample> imu);

/// The rows of its parameters: of each camera (fx, fy, cx, cy, coefficients), the errors of
/// cam_T_imu (R = Exp(phi) Rhat, p = phat + dp, in the camera's axes) [rad, m], the time offset [s]
/// and, with has_readout, the readout time [s]; of each recording the direction of gravity [rad],
/// in turns about g.unitOrthogonal() and about the axis across it and g; the IMU's scales and
/// misalignments, as ImuCorrection; the shape of the target.
class InertialLayout {
 public:
  explicit InertialLayout(const std::vector<LensForm>& lenses = {}, bool has_readout = false,
                          int imu_rows = 0, std::vector<std::string> shape_names = {},
                          std::size_t recordings = 1);

  int lens_row(std::size_t camera) const { return first_[camera]; }
  int pose_row(std::size_t camera) const { return first_[camera] + lenses_[camera].parameters(); }
  int offset_row(std::size_t camera) const { return pose_row(camera) + 6; }
  int readout_row(std::size_t camera) const { return offset_row(camera) + 1; }
  int gravity_row(std::size_t recording = 0) const {
    return first_.back() + 2 * static_cast<int>(recording);
  }
  int imu_row() const { return gravity_row(recordings_); }
  int shape_row() const { return imu_row() + imu_rows_; }
  int rows() const { return shape_row() + static_cast<int>(shape_names_.size()); }
  const LensForm& lens(std::size_t camera) const { return lenses_[camera]; }
  std::size_t cameras() const { return lenses_.size(); }
  bool has_readout() const { return has_readout_; }
  int shape_rows() const { return static_cast<int>(shape_names_.size()); }
  std::vector<std::string> names(const ImuCorrection& imu) const;

 private:
  std::vector<LensForm> lenses_;
  bool has_readout_;
  int imu_rows_;
  std::vector<std::string> shape_names_;
  std::size_t recordings_;
  std::vector<int> first_;
};

struct InertialCalibration {
  std::vector<Camera> cameras;                  ///< with cam_T_imu and readout
  std::vector<double> time_offsets;             ///< of each: camera clock + offset = IMU clock [s]
  std::vector<Eigen::Vector3d> gravity_target;  ///< of each recording [m/s^2]
  ImuCorrection imu = {};                       ///< zero if not estimated
  Vector6d biases = Vector6d::Zero();           ///< mean: accelerometer [m/s^2], gyroscope [rad/s]
  Eigen::VectorXd shape;                        ///< of the target
  std::vector<std::string> names;               ///< of the rows
  Eigen::VectorXd values;                       ///< of rotations: the rotation vector
  Eigen::MatrixXd covariance;                   ///< of the parameters
  /// Of each before any view; infinite where nothing was known.
  Eigen::VectorXd prior_sigmas = {};
  InertialLayout layout;
  CamerasCalibration alone;       ///< the cameras without the IMU
  double pixel_sigma = 0;         ///< robust scatter of a corner's u or v [px]
  int pieces = 0;                 ///< of views with independent errors
  double correlation_factor = 1;  ///< as CamerasCalibration
  /// By how much the residuals of the IMU are larger than its stated noise: of the gyroscope and of
  /// the accelerometer. At least 1; the result is weighted with them.
  double gyroscope_factor = 1, accelerometer_factor = 1;
  /// At each instant with views, by the IMU's clock; world: the target's frame.
  std::vector<Time> state_times;
  std::vector<InertialState> states;
  double seconds = 0;  ///< from the first to the last of each recording
  int iterations = 0;
  std::vector<ExplainedView> views;  ///< errors at the lines of the corners
};

/// First the cameras alone, then all together. Throws InputError as calibrate_cameras(), for an IMU
/// that does not cover the views, where its rotation does not follow that of the cameras, and where
/// the motion does not determine the parameters: with what is missing.
InertialCalibration calibrate_inertial(const InertialCalibrationInput& input);

}  // namespace chasles
