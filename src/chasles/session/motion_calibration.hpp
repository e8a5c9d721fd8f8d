#pragma once

#include <string>
#include <vector>

#include <chasles/session/run_job.hpp>

namespace chasles {

/// Cameras with their IMU from ordinary motion, without a target.
struct MotionCalibration {
  std::vector<Camera> cameras;  ///< with cam_T_imu, lens and readout
  double time_offset = 0;       ///< camera clock + offset = IMU clock [s]
  /// `parameters` of summary.json's "calibration": stated, estimate and both sigmas of each.
  nlohmann::ordered_json parameters;
  /// Of each camera: of fx, fy, cx, cy and the coefficients.
  std::vector<Eigen::MatrixXd> lens_covariances;
  std::vector<std::string> remarks;
};

/// Batch estimation of the recording with extrinsics, lenses and clock as states, from the stated
/// ones with sigmas of 0.2 rad, 0.1 m and 0.1 s. `from_nothing`: the mounting of the first camera
/// is first measured by the rotations of its tracks against the gyroscope, and its place is that of
/// the IMU; the other cameras keep their poses against it. Changes the recording's cameras. Throws
/// as a run, and InputError where the rotations do not show the mounting.
MotionCalibration calibrate_from_motion(const SessionOptions& options, Recording& recording,
                                        bool from_nothing, const StopRequest& stop);

/// The content of imu-cameras.json without a target: parameters and remarks.
nlohmann::ordered_json motion_json(const MotionCalibration& calibration);
/// The table of the terminal.
std::string motion_text(const MotionCalibration& calibration);

}  // namespace chasles
