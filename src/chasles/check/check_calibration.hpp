#pragma once

#include <optional>
#include <vector>

#include <chasles/check/camera_fit.hpp>
#include <chasles/check/check_report.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Findings about a mistake in the lens, the signs and the scale of the gyroscope, the time offset
/// between camera and IMU, a rolling shutter, and the rotation of the camera, in this order. Those
/// after a mistake are with the mistake undone: what it explains is no finding of its own.
void report_camera_fit(const CameraFit& fit, const Camera& camera, const std::string& about,
                       CheckReport& report);

/// Findings for a fisheye lens whose coefficients are all zero, and for a principal point that is
/// farther from the middle than a quarter of the image: the calibration of another size.
void report_lenses(const std::vector<Camera>& cameras, CheckReport& report);

/// Facts and findings about the second and further cameras relative to the first: baseline and
/// angle. For tracks that both observe: whether the points lie in front of the cameras, and their
/// distances from the epipolar lines.
void report_stereo(const std::vector<Camera>& cameras, const std::vector<FeatureFrame>& frames,
                   CheckReport& report);

/// Checks that the disparities of a rectified pair are positive and its rows agree.
void report_rectified(const std::vector<FeatureFrame>& frames, CheckReport& report);

}  // namespace chasles
