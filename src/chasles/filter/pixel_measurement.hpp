#pragma once

#include <optional>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {

// If the extrinsics of a camera are estimated (State::imu_T_camera), the functions use those of the
// state and ignore cam_T_imu; `index` is the camera's index there. `sigma` is the pixel noise [px].

/// Observation of a landmark of the state by a camera: residual [px], derivatives (reference chart;
/// docs/derivations.md, D38), noise sigma^2 I [px^2]. None if the landmark has no projection.
std::optional<Measurement> measure_pixel(const Camera& camera, double sigma, const State& x,
                                         int landmark, const Eigen::Vector2d& pixel,
                                         Linearisation at = Linearisation::kCurrent, int index = 0);
/// The same into an existing measurement; false for none.
bool measure_pixel(const Camera& camera, double sigma, const State& x, int landmark,
                   const Eigen::Vector2d& pixel, Linearisation at, int index, Measurement& result);

/// Second-order covariance [px^2] of the pixel of an anchored landmark, which the linear
/// measure_pixel() neglects. A pixel moves by inverse depth w times displacement from the anchor.
/// If both are uncertain, the product of the two errors has the covariance var(w) cov(displacement)
/// + cov(w, displacement) cov(w, displacement)^T. Of the second-order terms of Athans, Wishner &
/// Bertolini (IEEE T-AC 1968), this one dominates while the displacement is small compared with the
/// depth. Zero for a Cartesian landmark.
Eigen::Matrix2d bilinear_noise(const Camera& camera, const Ekf& filter, int landmark, int index);

/// The noise of a landmark's parameters if its point moves across the ray by `variance` [px^2] in
/// each coordinate of the pixel: a pixel of the anchor's camera for an anchored landmark, of this
/// camera at the present pose for a Cartesian one. The distance is without noise.
Eigen::Matrix3d drift_noise(const Camera& camera, const State& x, const Landmark& landmark,
                            double variance, int index);

/// Undelayed initialisation of a landmark on the pixel's ray, at a depth [m] of the given mean and
/// standard deviation (Kleinert & Stilla). The depth is along the camera's axis, or for a ray that
/// is not ahead (is_ahead), the distance. None if the lens model has no ray.
std::optional<NewLandmark> initialise_at_depth(const Camera& camera, double sigma, const State& x,
                                               LandmarkId id, const Eigen::Vector2d& pixel,
                                               double depth, double depth_sigma, int index = 0);

/// Undelayed initialisation of an anchored landmark in the camera of the latest clone, which must
/// be a clone of the current pose, at an inverse depth [1/m] of the given mean and standard
/// deviation, in the axes of the ray's face. None if the lens model has no ray.
std::optional<NewLandmark> initialise_anchored(const Camera& camera, double sigma, const State& x,
                                               LandmarkId id, const Eigen::Vector2d& pixel,
                                               double inverse_depth, double inverse_depth_sigma,
                                               int index = 0);

}  // namespace chasles
