#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/session/check_motion_calibration.hpp>

namespace chasles {
namespace {

constexpr double kMostSigmas = 4;

// What is compared, and from where on a filter notices it: about twice of what its defaults allow
// for, or of the noise of a track.
struct Compared {
  const char* what;
  const char* unit;
  double scale;  // to the unit
  double noticed;
};
constexpr Compared kLens{"lens", "px", 1, 1};
constexpr Compared kRotation{"mounting", "deg", kDegrees, 1};
constexpr Compared kPlace{"place on the IMU", "cm", 100, 3};
constexpr Compared kClock{"clock", "ms", 1e3, 3};

struct Difference {
  double size = 0, sigmas = 0;
  std::string detail;  // of the number that is farthest off
};

void report_difference(const Compared& compared, const std::string& about, const Difference& d,
                       const std::string& advice, CheckReport& report) {
  const std::string name = fmt::format("{} against the motion", compared.what);
  report.facts.push_back({about, name, compared.scale * d.size, compared.unit});
  report.facts.push_back({about, name + " over its sigma", d.sigmas, ""});
  if (d.sigmas <= kMostSigmas) return;
  const double size = compared.scale * d.size;
  report.findings.push_back(
      {.severity = size > compared.noticed ? Severity::kWarning : Severity::kNote,
       .about = about,
       .what = fmt::format("its {} is off by {:.1f} sigma of what the motion shows, {:.2g} {}{}",
                           compared.what, d.sigmas, size, compared.unit, d.detail),
       .value = d.sigmas,
       .threshold = kMostSigmas,
       .unit = "sigma",
       .advice = advice});
}

using Json = nlohmann::ordered_json;

// Of the numbers whose names begin so: the length of their difference, and how far the farthest is.
Difference difference_of(const Json& parameters, const std::string& prefix) {
  Difference result;
  double squares = 0;
  for (const Json& one : parameters) {
    const std::string name = one.at("name");
    if (!name.starts_with(prefix)) continue;
    const double stated = one.at("stated"), estimate = one.at("estimate"), sigma = one.at("sigma");
    squares += (estimate - stated) * (estimate - stated);
    const double sigmas = std::abs(estimate - stated) / sigma;
    if (sigmas < result.sigmas) continue;
    result.sigmas = sigmas;
    result.detail = fmt::format(" ({}: {:.5g} stated, {:.5g} +- {:.2g} {} found)", name, stated,
                                estimate, sigma, one.at("unit").get<std::string>());
  }
  result.size = std::sqrt(squares);
  return result;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, values.size())));
}

// Single numbers of a lens stand for each other, so its pixels are compared.
Difference difference_of_lens(const Camera& stated, const Camera& found,
                              const Eigen::MatrixXd& covariance, const Difference& numbers) {
  std::vector<double> pixels, sigmas;
  for (const PixelDifference& one : projection_difference(stated, found)) {
    pixels.push_back(one.difference.norm());
  }
  for (const PixelUncertainty& one : projection_uncertainty(found, covariance)) {
    sigmas.push_back(one.sigma_px);
  }
  return {.size = rms(pixels), .sigmas = rms(pixels) / rms(sigmas), .detail = numbers.detail};
}

}  // namespace

void report_motion_calibration(const MotionCalibration& found, const std::vector<Camera>& stated,
                               CheckReport& report) {
  for (std::size_t c = 0; c < stated.size(); ++c) {
    const std::string about = fmt::format("cam{}", c);
    const Difference numbers = difference_of(found.parameters, about + "_");
    report_difference(
        kLens, about,
        difference_of_lens(stated[c], found.cameras[c], found.lens_covariances[c], numbers),
        "calibrate it (`chasles calibrate cameras`), or run with --set calibrate_intrinsics=true",
        report);
    const std::string mounted = "imu_T_" + about + "_";
    Difference place{};
    for (const char* axis : {"x", "y", "z"}) {
      const Difference one = difference_of(found.parameters, mounted + axis);
      place.size = std::hypot(place.size, one.size);
      if (one.sigmas > place.sigmas) place.sigmas = one.sigmas, place.detail = one.detail;
    }
    const std::string advice =
        "calibrate it (`chasles calibrate imu-cameras`), or run with --set calibrate_extrinsics="
        "true";
    report_difference(kRotation, about, difference_of(found.parameters, mounted + "turned_"),
                      advice, report);
    report_difference(kPlace, about, place, advice, report);
  }
  report_difference(kClock, "cameras", difference_of(found.parameters, "time_offset"),
                    "run with --set calibrate_time_offset=true", report);
}

void compare_with_motion(const SessionOptions& options, Recording recording,
                         const StopRequest& stop, CheckReport& report) {
  const std::vector<Camera> stated = recording.cameras;
  try {
    report_motion_calibration(calibrate_from_motion(options, recording, false, stop), stated,
                              report);
  } catch (const Error& error) {
    report.not_checked.push_back(
        fmt::format("the calibration against the motion: {}", error.what()));
  }
}

}  // namespace chasles
