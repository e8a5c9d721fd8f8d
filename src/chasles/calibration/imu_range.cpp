#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <chasles/calibration/imu_range.hpp>

namespace chasles {
namespace {

constexpr double kLeastForceRange = 19;  // two g [m/s^2]
constexpr double kLeastRateRange = 2.1;  // 125 deg/s [rad/s]
constexpr std::size_t kRun = 3;          // successive samples that are the same
constexpr double kAxisRepeats = 0.05;
constexpr double kEnds = 1e-3;

using Value = Eigen::Vector3d ImuSample::*;

// Whether the samples are read faster than they are measured.
bool repeats(const std::vector<ImuSample>& imu, Value value) {
  std::size_t repeated = 0;
  for (std::size_t i = 1; i < imu.size(); ++i) repeated += imu[i].*value == imu[i - 1].*value;
  return static_cast<double>(repeated) > kAxisRepeats * static_cast<double>(imu.size());
}

// Whether an axis stays at `largest`, or at its negative, for several samples.
bool stays_at(const std::vector<ImuSample>& imu, Value value, int axis, double largest) {
  std::size_t run = 0;
  for (std::size_t i = 0; i < imu.size() && run < kRun; ++i) {
    const double x = (imu[i].*value)[axis];
    const bool same = run > 0 && x == (imu[i - 1].*value)[axis];
    run = std::abs(x) == largest ? (same ? run : 0) + 1 : 0;
  }
  return run >= kRun;
}

double shown(const std::vector<ImuSample>& imu, Value value, double least) {
  double largest = 0;
  for (const ImuSample& s : imu) largest = std::max(largest, (s.*value).cwiseAbs().maxCoeff());
  bool clipped = false;
  for (int axis = 0; axis < 3; ++axis) clipped = clipped || stays_at(imu, value, axis, largest);
  if (!clipped || largest < least || repeats(imu, value)) {
    return std::numeric_limits<double>::infinity();
  }
  return (1 - kEnds) * largest;
}

}  // namespace

ImuRange read_imu_range(const YamlMap& map) {
  ImuRange range;
  if (map.has("accelerometer_range")) range.accelerometer = map.positive("accelerometer_range");
  if (map.has("gyroscope_range")) range.gyroscope = map.positive("gyroscope_range");
  return range;
}

std::string imu_range_text(const ImuRange& range, const std::string& indent) {
  std::string text;
  if (std::isfinite(range.accelerometer)) {
    text +=
        fmt::format("{}accelerometer_range: {} # m/s^2, either way\n", indent, range.accelerometer);
  }
  if (std::isfinite(range.gyroscope)) {
    text += fmt::format("{}gyroscope_range: {} # rad/s, either way\n", indent, range.gyroscope);
  }
  return text;
}

ImuRange shown_range(const std::vector<ImuSample>& imu) {
  return {.accelerometer = shown(imu, &ImuSample::specific_force_imu, kLeastForceRange),
          .gyroscope = shown(imu, &ImuSample::angular_rate_imu, kLeastRateRange)};
}

std::size_t count_saturated(const std::vector<ImuSample>& imu, const ImuRange& range) {
  return static_cast<std::size_t>(std::count_if(imu.begin(), imu.end(), [&](const ImuSample& s) {
    return s.force_clipped || s.rate_clipped ||
           s.specific_force_imu.cwiseAbs().maxCoeff() >= range.accelerometer ||
           s.angular_rate_imu.cwiseAbs().maxCoeff() >= range.gyroscope;
  }));
}

}  // namespace chasles
