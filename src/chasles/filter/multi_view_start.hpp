#pragma once

#include <optional>
#include <span>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/scratch.hpp>

namespace chasles {

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
  Reused<Measurement> rest;  ///< independent of the landmark and its noise
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

/// What begin_multi_view writes on the way.
struct MultiViewScratch {
  std::vector<Camera> cameras;  ///< as estimated
  std::vector<View> views;
  std::vector<int> rows;  ///< of the clones and cameras that the views depend on, each once
  Scratch r, H_point, H_others, moved, d_point, workspace;
};

/// Triangulates and linearises all views at the least-squares point. An orthogonal change of rows
/// separates the point from the rest, so that each observation counts once: the landmark's noise
/// and the rest's are independent. An anchored landmark hangs on the last view's clone. None where
/// the views do not meet in a point in front of all.
std::optional<MultiViewStart> begin_multi_view(std::span<const Camera> cameras, double sigma,
                                               const State& x, LandmarkId id,
                                               std::span<const ClonedView> views, bool anchored,
                                               Linearisation at = Linearisation::kCurrent);
/// The same into a start that there is; false for none, and then the start has no meaning.
bool begin_multi_view(std::span<const Camera> cameras, double sigma, const State& x, LandmarkId id,
                      std::span<const ClonedView> views, bool anchored, Linearisation at,
                      MultiViewScratch& scratch, MultiViewStart& result);

}  // namespace chasles
