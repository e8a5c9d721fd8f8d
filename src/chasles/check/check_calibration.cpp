#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/check/camera_clock.hpp>
#include <chasles/check/check_calibration.hpp>
#include <chasles/check/other_axes.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kRotationOff = 2 * kRadians;
constexpr double kRotationUnknown = 2 * kRadians;  // a larger standard deviation is no information
constexpr double kOffset = 0.005;                  // [s]
constexpr double kGainOff = 0.06;
constexpr double kFocalOff = 0.08;
constexpr double kCentreOff = 0.25;  // of a principal point from the middle, over the image
constexpr double kSigmas = 4;

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return so3::log(a.transpose() * b).norm();
}

// What a run does with the offset (pipeline/measured_offset.hpp).
std::string run_with_offset(const CameraFit& fit) {
  const auto clock = camera_clock(fit);
  if (clock && clock->stands_out()) return "a run of images measures it, and starts from it";
  return fmt::format("--set time_offset={:.4f} starts from it", fit.offset().value);
}

// Of a rolling shutter of which nothing is stated, stamps may be those of the middle row or of the
// first line.
Measured likely_offset(const CameraFit& fit) {
  Measured offset = fit.offset();
  if (fit.shutter.is_rolling() || !fit.lens || !fit.lens->is_rolling()) return offset;
  const double of_first = offset.value - std::abs(fit.lens->readout.value) / 2;
  if (std::abs(of_first) < std::abs(offset.value)) offset.value = of_first;
  return offset;
}

void report_offset(const CameraFit& fit, const std::string& about, CheckReport& report) {
  const Measured offset = likely_offset(fit);
  report.facts.push_back({about, "offset to the gyroscope", 1e3 * offset.value, "ms"});
  const double limit = std::max(kOffset, kSigmas * offset.sigma);
  const double size = std::abs(offset.value);
  if (size <= limit) return;
  // A negative offset means that the camera's stamp is too late.
  const bool late = offset.value < 0;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what = fmt::format("the camera is stamped {} by {:.0f} ms against the gyroscope",
                           late ? "late" : "early", 1e3 * size),
       .value = 1e3 * size,
       .threshold = 1e3 * limit,
       .unit = "ms",
       .advice = fmt::format("{} {:.1f} ms {} its stamps; {}", late ? "take" : "add", 1e3 * size,
                             late ? "off" : "to", run_with_offset(fit))});
}

std::string gain_advice(double gain, const std::optional<LensFit>& lens) {
  if (std::abs(gain * 180 / std::numbers::pi - 1) < 0.2) {
    return "the gyroscope seems to be in deg/s: convert it to rad/s";
  }
  if (lens && lens->gain.differs(1, kGainOff) && !lens->focal.differs(0, kFocalOff)) {
    return gain < 1 ? "check the gyroscope's unit (rad/s) and range, and whether the video is "
                      "stabilised"
                    : "check the gyroscope's unit (rad/s) and range";
  }
  return "check the gyroscope's unit (rad/s) and the focal length";
}

void report_gain(const CameraFit& fit, const std::string& about, CheckReport& report) {
  const GyroscopeFit& g = *fit.gyroscope;
  const double limit = std::max(kGainOff, kSigmas * g.gain_sigma);
  if (std::abs(g.gain - 1) <= limit) return;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what =
           fmt::format("the images rotate {:.3g} times as fast as the gyroscope measures", g.gain),
       .value = std::abs(g.gain - 1),
       .threshold = limit,
       .unit = "",
       .advice = gain_advice(g.gain, fit.lens)});
}

void report_mistake(const LensGuess& mistake, const std::string& about, CheckReport& report) {
  report.findings.push_back({.severity = Severity::kError,
                             .about = about,
                             .what = mistake.what,
                             .value = mistake.value,
                             .threshold = mistake.threshold,
                             .unit = mistake.unit,
                             .advice = mistake.advice});
}

// By its sign: upwards below 0.
double signed_readout(const Shutter& shutter) {
  return shutter.direction == ReadoutDirection::kUp ? -shutter.readout : shutter.readout;
}

bool is_by_columns(const Shutter& shutter) {
  return shutter.is_rolling() && (shutter.direction == ReadoutDirection::kRight ||
                                  shutter.direction == ReadoutDirection::kLeft);
}

void report_stated_readout(const LensFit& lens, const Shutter& shutter, const std::string& about,
                           CheckReport& report) {
  const double stated = signed_readout(shutter);
  if (!lens.readout.differs(stated, LensFit::kLeastReadout)) return;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what =
           fmt::format("its rows are read out in {:.1f} +- {:.1f} ms, and its readout_time says "
                       "{:.1f} ms (below 0: upwards)",
                       1e3 * lens.readout.value, 1e3 * lens.readout.sigma, 1e3 * stated),
       .value = 1e3 * std::abs(lens.readout.value - stated),
       .threshold = 1e3 * LensFit::kLeastReadout,
       .unit = "ms",
       .advice = "check readout_time and readout_direction, and whether they are of this mode of "
                 "the camera"});
}

void report_readout(const LensFit& lens, const Shutter& shutter, const std::string& about,
                    CheckReport& report) {
  report.facts.push_back({about, "readout of the rows", 1e3 * lens.readout.value, "ms"});
  if (is_by_columns(shutter)) return;
  if (shutter.is_rolling()) return report_stated_readout(lens, shutter, about, report);
  if (!lens.is_rolling()) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what = fmt::format("its rows are exposed one after the other (rolling shutter), in {:.0f} "
                           "+- {:.0f} ms from the {} to the {}",
                           1e3 * std::abs(lens.readout.value), 1e3 * lens.readout.sigma,
                           lens.readout.value > 0 ? "first" : "last",
                           lens.readout.value > 0 ? "last" : "first"),
       .value = 1e3 * std::abs(lens.readout.value),
       .threshold = 1e3 * LensFit::kLeastReadout,
       .unit = "ms",
       .advice = fmt::format("state readout_time: {:.4f}{} of the camera (docs/formats.md); a run "
                             "of images measures it too, and takes each row at its own time",
                             std::abs(lens.readout.value),
                             lens.readout.value > 0 ? "" : " and readout_direction: up")});
}

void report_signs(const Eigen::Vector3d& signs, const std::string& about, CheckReport& report) {
  const std::string axes = OtherAxes{.signs = signs}.mirrored();
  if (axes.empty()) return;
  const bool all = signs.maxCoeff() < 0;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what = fmt::format(
           "the gyroscope fits the images only as a mirror image: {}",
           all ? "its sign is wrong" : fmt::format("the sign of its {} axis is wrong", axes)),
       .value = signs.array().min(0).abs().sum(),
       .threshold = 0,
       .unit = "axes",
       .advice = fmt::format("change the sign of {} in the samples: angular rates are positive "
                             "anticlockwise, seen from the tip of the axis; a run of images "
                             "changes it too, if gravity then keeps its direction",
                             all ? "the gyroscope" : fmt::format("the gyroscope's {}", axes))});
}

Finding rotation_finding(const CameraFit& of_camera, const Camera& camera, double limit) {
  const GyroscopeFit& fit = *of_camera.gyroscope;
  const Eigen::Matrix3d& cam_R_imu = camera.cam_T_imu.R;
  const double off = angle_between(cam_R_imu, fit.cam_R_imu);
  const double inverted = angle_between(cam_R_imu.transpose(), fit.cam_R_imu);
  Finding finding{.severity = Severity::kError,
                  .value = off / kRadians,
                  .threshold = limit / kRadians,
                  .unit = "deg"};
  if (fit.mirrored) {
    finding.what = "the gyroscope fits the images only as a mirror image";
    finding.advice = "one axis of the IMU or of the camera is flipped: frames are right-handed";
  } else if (inverted < std::max(limit, off / 3)) {
    finding.what = fmt::format(
        "the extrinsics seem to be inverted: {:.1f} deg off, and {:.1f} deg as the inverse",
        off / kRadians, inverted / kRadians);
    finding.advice = "give the inverse: cam_T_imu maps IMU coordinates to those of the camera";
  } else {
    finding.what = fmt::format("its rotation against the IMU is off by {:.1f} deg", off / kRadians);
    const auto axes = other_axes(of_camera, camera);
    finding.advice = axes && axes->has_turn()
                         ? fmt::format(
                               "the IMU's samples, or the extrinsics, have other axes: where "
                               "the extrinsics state x, y, z of the IMU, its samples have {} "
                               "(camera: x right, y down, z forward); a run of images turns the "
                               "samples, if gravity then keeps its direction",
                               axes->turned())
                     : off > 30 * kRadians ? "check the axes: camera x right, y down, z forward"
                                           : "calibrate the camera against the IMU again";
  }
  return finding;
}

void report_rotation(const CameraFit& of_camera, const Camera& camera, const std::string& about,
                     CheckReport& report) {
  const GyroscopeFit& fit = *of_camera.gyroscope;
  const Eigen::Matrix3d& cam_R_imu = camera.cam_T_imu.R;
  if (fit.rotation_sigma > kRotationUnknown && !fit.mirrored) {
    report.not_checked.push_back(fmt::format(
        "the rotation of {} against the IMU: the recording rotates too little, or about one axis "
        "only ({:.1f} deg uncertain)",
        about, fit.rotation_sigma / kRadians));
    return;
  }
  const double off = angle_between(cam_R_imu, fit.cam_R_imu);
  report.facts.push_back({about, "rotation off", off / kRadians, "deg"});
  const double limit = std::max(kRotationOff, kSigmas * fit.rotation_sigma);
  if (off <= limit && !fit.mirrored) return;
  report.findings.push_back(rotation_finding(of_camera, camera, limit));
  report.findings.back().about = about;
}

// `part`: the principal point over the size of the images.
std::string centre_advice(const Eigen::Vector2d& part) {
  constexpr double kSameScale = 0.15;
  if (std::abs(part.x() / part.y() - 1) > kSameScale) {
    return "check cx and cy, and their order: intrinsics are fx, fy, cx, cy";
  }
  return fmt::format(
      "the calibration may be that of images {:.2g} times as large: scale fx, fy, cx and cy with "
      "the images, and move cx and cy where they are cut",
      2 * part.mean());
}

void report_principal_point(const Camera& camera, const std::string& about, CheckReport& report) {
  if (camera.width <= 0 || camera.height <= 0) return;
  const Eigen::Vector2d part((camera.cx + 0.5) / camera.width, (camera.cy + 0.5) / camera.height);
  const double off = (part.array() - 0.5).abs().maxCoeff();
  if (off <= kCentreOff) return;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what =
           fmt::format("its principal point ({:.1f}, {:.1f}) is far from the middle of its images "
                       "of {} x {} px",
                       camera.cx, camera.cy, camera.width, camera.height),
       .value = 100 * off,
       .threshold = 100 * kCentreOff,
       .unit = "% of the image",
       .advice = centre_advice(part)});
}

}  // namespace

void report_lenses(const std::vector<Camera>& cameras, CheckReport& report) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    report_principal_point(cameras[c], fmt::format("cam{}", c), report);
    if (cameras[c].distortion != Distortion::kEquidistant) continue;
    if (!cameras[c].coefficients.is_zero()) continue;
    report.findings.push_back(
        {.severity = Severity::kWarning,
         .about = fmt::format("cam{}", c),
         .what = "is a fisheye lens (equidistant) whose coefficients are all 0",
         .value = 0,
         .threshold = 0,
         .unit = "",
         .advice = "that is an ideal fisheye lens; images without distortion have the model "
                   "'radtan' with zeros, or 'none'"});
  }
}

void report_camera_fit(const CameraFit& fit, const Camera& camera, const std::string& about,
                       CheckReport& report) {
  if (fit.stated) {
    report.facts.push_back({about, "turns over the gyroscope's", fit.stated->gain, ""});
  }
  if (fit.mistake) report_mistake(*fit.mistake, about, report);
  report_signs(fit.signs, about, report);
  if (fit.gyroscope) report_gain(fit, about, report);
  if (!fit.agrees()) {
    report.not_checked.push_back(
        fmt::format("clock and rotation of {} against the IMU: the images do not rotate as the "
                    "gyroscope measures; see the findings",
                    about));
    return;
  }
  report_offset(fit, about, report);
  if (fit.lens) {
    if (!fit.mistake) {
      const double edge = 100 * fit.lens->radial_at_edge().value;
      report.facts.push_back({about, "lens error at the edge", edge, "%"});
    }
    report_readout(*fit.lens, camera.shutter, about, report);
  }
  report_rotation(fit, camera, about, report);
}

}  // namespace chasles
