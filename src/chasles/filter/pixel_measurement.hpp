#pragma once

#include <optional>
#include <span>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/feature_frame.hpp>
#include <chasles/filter/ekf.hpp>

namespace chasles {

// A camera whose place on the IMU is estimated (State::imu_T_camera) is taken to be where the state
// has it, whatever its cam_T_imu says; `index` is its number there.

/// A landmark of the state seen by a camera: residual, derivatives (reference chart, math.md §3),
/// noise sigma^2 I [px^2]. None if the landmark has no projection.
std::optional<Measurement> measure_pixel(const Camera& camera, double sigma, const State& x,
                                         int landmark, const Eigen::Vector2d& pixel,
                                         Linearisation at = Linearisation::kCurrent, int index = 0);

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

/// A landmark seen from a clone.
struct ClonedView {
  int clone = 0;  ///< id
  int camera = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A point that several clones have seen, taken apart into what determines the point and what is
/// left: 2 rows a view, 3 go to the landmark, the others say something of the clones (and of the
/// imu_T_camera that are estimated) alone.
struct MultiViewStart {
  NewLandmark landmark;
  std::vector<Measurement> rest;  ///< independent of the landmark and its noise
  int rest_rows = 0;
  double parallax = 0;  ///< largest angle between two rays [rad]

  /// The distance of the point from the last view's IMU [m], its derivative by the same errors, and
  /// the variance that the pixels leave it.
  double distance = 0;
  struct OfClone {
    int row = 0;  ///< of the six
    Eigen::Matrix<double, 1, 6> d;
  };
  std::vector<OfClone> d_distance;
  double distance_noise = 0;  ///< [m^2]
};

/// Deviation of that distance over the distance, with what the filter does not know of the clones
/// and cameras: how good the first linearisation is.
double relative_depth_sigma(const MultiViewStart& start, const Ekf& filter);

/// Triangulates and linearises all views at the least-squares point. An orthogonal change of rows
/// separates the point from the rest, so that each observation counts once: the landmark's noise
/// and the rest's are independent. An anchored landmark hangs on the last view's clone. None where
/// the views do not meet in a point in front of all.
std::optional<MultiViewStart> begin_multi_view(std::span<const Camera> cameras, double sigma,
                                               const State& x, LandmarkId id,
                                               std::span<const ClonedView> views, bool anchored,
                                               Linearisation at = Linearisation::kCurrent);

}  // namespace chasles
