#pragma once

#include <optional>
#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/check/check_rotation.hpp>
#include <chasles/check/lens_fit.hpp>
#include <chasles/data/recording.hpp>

namespace chasles {

/// Findings about the rotation of a camera relative to the IMU, the time offset between them, the
/// scale of the gyroscope, the lens, and a rolling shutter: the fits compared with the calibration.
/// A wrong lens explains a gain of its own, and a rolling shutter an offset. `lens`: none where
/// fit_lens() finds nothing.
void report_gyroscope_fit(const GyroscopeFit& fit, const std::optional<LensFit>& lens,
                          const SE3& cam_T_imu, const std::string& about, CheckReport& report);

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
