#pragma once

#include <optional>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {

// A camera whose place on the IMU is estimated (State::imu_T_camera) is taken to be where the state
// has it, whatever its cam_T_imu says; `index` is its number there.

/// A landmark of the state seen by a camera: residual, derivatives (reference chart;
/// docs/derivations.md, D38), noise sigma^2 I [px^2]. None if the landmark has no projection.
std::optional<Measurement> measure_pixel(const Camera& camera, double sigma, const State& x,
                                         int landmark, const Eigen::Vector2d& pixel,
                                         Linearisation at = Linearisation::kCurrent, int index = 0);
/// The same into a measurement that there is; false for none.
bool measure_pixel(const Camera& camera, double sigma, const State& x, int landmark,
                   const Eigen::Vector2d& pixel, Linearisation at, int index, Measurement& result);

/// What the linear measure_pixel() of an anchored landmark leaves out where its depth and the way
/// from its anchor are both uncertain: a pixel moves by inverse depth x way, and the covariance of
/// the product of the two errors is var(w) cov(way) + cov(w, way) cov(w, way)^T, in pixels [px^2]
/// (of the second-order terms of Athans, Wishner & Bertolini, IEEE T-AC 1968, the one that counts
/// while the way is short against the depth). Zero for a Cartesian one.
Eigen::Matrix2d bilinear_noise(const Camera& camera, const Ekf& filter, int landmark, int index);

/// A landmark `depth` along the pixel's ray, uncertain by `depth_sigma` along it: Kleinert &
/// Stilla's initialisation. None where the lens model has no ray.
std::optional<NewLandmark> begin_at_depth(const Camera& camera, double sigma, const State& x,
                                          LandmarkId id, const Eigen::Vector2d& pixel, double depth,
                                          double depth_sigma, int index = 0);

/// An anchored landmark in the camera of the latest clone, which must be of the present pose, with
/// an inverse depth [1/m] of that mean and deviation.
std::optional<NewLandmark> begin_anchored(const Camera& camera, double sigma, const State& x,
                                          LandmarkId id, const Eigen::Vector2d& pixel,
                                          double inverse_depth, double inverse_depth_sigma,
                                          int index = 0);

}  // namespace chasles
