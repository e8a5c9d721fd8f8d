#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <chasles/check/check_calibration.hpp>
#include <chasles/constants.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kRotationOff = 2 * kRadians;
constexpr double kRotationUnknown = 2 * kRadians;  // a larger standard deviation is no information
constexpr double kOffset = 0.005;                  // [s]
constexpr double kGainOff = 0.1;
constexpr double kSigmas = 4;

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return so3::log(a.transpose() * b).norm();
}

void report_offset(const GyroscopeFit& fit, const std::string& about, CheckReport& report) {
  report.facts.push_back({about, "offset to the gyroscope", 1e3 * fit.offset, "ms"});
  const double limit = std::max(kOffset, kSigmas * fit.offset_sigma);
  if (std::abs(fit.offset) <= limit) return;
  // A negative offset means that the camera's stamp is too late.
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what = fmt::format("the camera is stamped {} by {:.0f} ms against the gyroscope",
                           fit.offset < 0 ? "late" : "early", 1e3 * std::abs(fit.offset)),
       .value = 1e3 * std::abs(fit.offset),
       .threshold = 1e3 * limit,
       .unit = "ms",
       .advice = fmt::format("{} {:.1f} ms {} its stamps, or let the filter estimate the offset",
                             fit.offset < 0 ? "take" : "add", 1e3 * std::abs(fit.offset),
                             fit.offset < 0 ? "off" : "to")});
}

std::string gain_advice(double gain) {
  if (std::abs(gain * 180 / std::numbers::pi - 1) < 0.2) {
    return "the gyroscope seems to be in deg/s: convert it to rad/s";
  }
  return "check the gyroscope's unit (rad/s) and the focal length";
}

void report_gain(const GyroscopeFit& fit, const std::string& about, CheckReport& report) {
  report.facts.push_back({about, "turns over the gyroscope's", fit.gain, ""});
  const double limit = std::max(kGainOff, kSigmas * fit.gain_sigma);
  if (std::abs(fit.gain - 1) <= limit) return;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what = fmt::format("the images rotate {:.3g} times as fast as the gyroscope measures",
                           fit.gain),
       .value = std::abs(fit.gain - 1),
       .threshold = limit,
       .unit = "",
       .advice = gain_advice(fit.gain)});
}

Finding rotation_finding(const GyroscopeFit& fit, const Eigen::Matrix3d& cam_R_imu, double limit) {
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
    finding.advice = off > 30 * kRadians ? "check the axes: camera x right, y down, z forward"
                                         : "calibrate the camera against the IMU again";
  }
  return finding;
}

void report_rotation(const GyroscopeFit& fit, const Eigen::Matrix3d& cam_R_imu,
                     const std::string& about, CheckReport& report) {
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
  report.findings.push_back(rotation_finding(fit, cam_R_imu, limit));
  report.findings.back().about = about;
}

}  // namespace

void report_lenses(const std::vector<Camera>& cameras, CheckReport& report) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (cameras[c].distortion != Distortion::kEquidistant) continue;
    if (!cameras[c].coefficients.isZero(0)) continue;
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

void report_gyroscope_fit(const GyroscopeFit& fit, const SE3& cam_T_imu, const std::string& about,
                          CheckReport& report) {
  report_gain(fit, about, report);
  report_offset(fit, about, report);
  report_rotation(fit, cam_T_imu.R, about, report);
}

}  // namespace chasles
