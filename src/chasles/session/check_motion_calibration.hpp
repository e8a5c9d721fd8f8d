#pragma once

#include <vector>

#include <chasles/check/check_report.hpp>
#include <chasles/session/motion_calibration.hpp>

namespace chasles {

/// Compares the `stated` cameras and their clock with those that batch estimation has found from
/// the motion of a recording. Facts: by how much each lens moves its pixels, in sigmas of the
/// estimate and in pixels (root mean square over the image, but for a turn of the camera), and the
/// same of mounting and clock. What is off by more than four sigmas is a finding: a warning where
/// it is large enough for a filter to notice, else a note.
void report_motion_calibration(const MotionCalibration& found, const std::vector<Camera>& stated,
                               CheckReport& report);

/// The same by calibrate_from_motion(). Where that has no result, a sentence of what is not
/// checked.
void compare_with_motion(const SessionOptions& options, Recording recording,
                         const StopRequest& stop, CheckReport& report);

}  // namespace chasles
