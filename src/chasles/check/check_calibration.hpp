#pragma once

#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/check/check_rotation.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// Findings about the rotation of a camera relative to the IMU, the time offset between them, and
/// the scale of the gyroscope: the fit compared with the calibration.
void report_gyroscope_fit(const GyroscopeFit& fit, const SE3& cam_T_imu, const std::string& about,
                          CheckReport& report);

/// A finding for a fisheye lens whose coefficients are all zero.
void report_lenses(const std::vector<Camera>& cameras, CheckReport& report);

/// Facts and findings about the second and further cameras relative to the first: baseline and
/// angle. For tracks that both observe: whether the points lie in front of the cameras, and their
/// distances from the epipolar lines.
void report_stereo(const std::vector<Camera>& cameras, const std::vector<FeatureFrame>& frames,
                   CheckReport& report);

/// Checks that the disparities of a rectified pair are positive and its rows agree.
void report_rectified(const std::vector<FeatureFrame>& frames, CheckReport& report);

}  // namespace chasles
