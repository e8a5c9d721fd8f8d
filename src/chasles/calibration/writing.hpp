#pragma once

#include <span>
#include <string>
#include <vector>

#include <chasles/calibration/foreign_writers.hpp>

namespace chasles {

/// A number with a decimal point: 458.0, 1.0e-05. YAML 1.1 (PyYAML) takes 1e-05 for a text, and
/// Kalibr takes no whole number for a focal length. It is the shortest text that reads back as the
/// same number.
std::string pointed(double value);

/// The same, between brackets.
std::string pointed_list(std::span<const double> values);

/// Four rows "- [...]" of a motion, each after `indent`.
std::string pointed_motion(const SE3& motion, const std::string& indent);

/// The calibration's remark and then further lines, each as a comment.
std::string as_comment(const CalibrationToWrite& calibration, const std::string& lines);

/// The offset of a camera; 0 where there are none [s].
double time_offset_of(const CalibrationToWrite& calibration, std::size_t camera);

/// The coefficients of a camera without the zeros at their end that its lens model can do without.
std::vector<double> stated_coefficients(const Camera& camera);

/// Throws InputError: "cam1: `format` has no lens model fov, expected `lenses`".
[[noreturn]] void no_such_lens(std::size_t camera, const Camera& lens, const std::string& format,
                               const std::string& lenses);

/// What a format has room for.
struct FormatRoom {
  bool time_offsets = false, shutter = false;
  bool imu_intrinsics = true;  ///< a format of cameras alone lacks no part of an IMU
};

/// A sentence that names what the calibration states and the format has no room for; empty if there
/// is nothing.
std::vector<std::string> without_room(const CalibrationToWrite& calibration,
                                      const std::string& format, const FormatRoom& room);

}  // namespace chasles
