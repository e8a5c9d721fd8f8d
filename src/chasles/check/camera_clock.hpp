#pragma once

#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/check/camera_fit.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The time offset of a camera's images, determined from the rotation of its tracks.
struct CameraClock {
  double offset = 0;  ///< camera time + offset = IMU time [s]; below 0: stamped late
  double sigma = 0;   ///< standard deviation of the offset [s]

  /// Two sigmas of a filter that starts from 0: smaller ones it finds by itself [s]
  /// (docs/inertial.md).
  static constexpr double kLeastOffset = 0.01;
  /// Of a measured offset: what the fit's own sigma does not contain, such as exposure times that
  /// change [s].
  static constexpr double kLeastSigma = 0.001;
  /// Whether the offset is larger than kLeastOffset and than ten sigmas.
  bool stands_out() const;
};

/// The offset of a fit; sigma is at least kLeastSigma. Nothing where the fit does not determine it:
/// where it does not agree, with a sigma above 3 ms, an offset at the end of the range of the
/// search, a mirror image, or a gain outside of 0.5 to 2.
std::optional<CameraClock> camera_clock(const CameraFit& fit);

/// The same from the tracks of the first camera. Nothing without cameras, or where
/// fit_camera() finds nothing.
std::optional<CameraClock> camera_clock(const std::vector<FeatureFrame>& tracks,
                                        const std::vector<Camera>& cameras,
                                        const std::vector<ImuSample>& imu);

/// The angular rates of IMU samples.
std::vector<StampedRate> gyroscope_rates(const std::vector<ImuSample>& imu);

}  // namespace chasles
