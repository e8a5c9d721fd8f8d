#pragma once

#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/check/check_rotation.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// Findings about where a camera is against the IMU, and how its clock and the gyroscope's scale
/// agree: what a fit says against what the calibration says.
void report_gyroscope_fit(const GyroscopeFit& fit, const SE3& cam_T_imu, const std::string& about,
                          CheckReport& report);

/// Facts and findings about the second and further cameras against the first: baseline and angle
/// and, where tracks are seen by both, whether these lie in front of the cameras and on each
/// other's epipolar lines.
void report_stereo(const std::vector<Camera>& cameras, const std::vector<FeatureFrame>& frames,
                   CheckReport& report);

/// Whether disparities are positive and rows agree for a rectified pair.
void report_rectified(const std::vector<FeatureFrame>& frames, CheckReport& report);

}  // namespace chasles
