#pragma once

#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/check/check_report.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// How the time offset of the first camera changes, by the rotation of its tracks.
struct ClockDrift {
  double rate = 0;   ///< of the offset, a second [s/s]; above 0: the camera's clock is slow
  double sigma = 0;  ///< its standard deviation [s/s]

  /// What no filter follows: it takes the offset as nearly constant (docs/inertial.md) [s/s].
  static constexpr double kLeast = 3e-4;
  /// Whether it is more than kLeast and than four sigmas.
  bool stands_out() const;
};

/// From the offsets (camera_clock()) of the first and of the last third of the tracks. Nothing
/// where one of them has none.
std::optional<ClockDrift> clock_drift(const std::vector<FeatureFrame>& tracks,
                                      const std::vector<Camera>& cameras,
                                      const std::vector<ImuSample>& imu);

/// Adds a finding on a drift that stands out.
void report_clock_drift(const std::optional<ClockDrift>& drift, CheckReport& report);

}  // namespace chasles
