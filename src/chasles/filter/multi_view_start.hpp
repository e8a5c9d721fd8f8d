#pragma once

#include <optional>
#include <span>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/track_noise.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/scratch.hpp>

namespace chasles {

/// Observation of a landmark from a clone.
struct ClonedView {
  int clone = 0;  ///< id
  int camera = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool match = false;  ///< PixelObservation::is_match()
};

/// A point observed from several clones, separated into the rows that determine the point and the
/// rest. Each view gives 2 rows. 3 rows go to the landmark; the others constrain only the clones
/// (and the estimated imu_T_camera).
struct MultiViewStart {
  NewLandmark landmark;
  Reused<Measurement> null_space;  ///< independent of the landmark and its noise
  int null_space_rows = 0;
  double parallax = 0;  ///< largest angle between two rays [rad]

  /// The distance of the point from the last view's IMU [m], its derivative by the same errors, and
  /// its variance due to the pixel noise.
  double distance = 0;
  struct OfClone {
    int row = 0;  ///< of the six
    Eigen::Matrix<double, 1, 6> d;
  };
  std::vector<OfClone> d_distance;
  double distance_noise = 0;  ///< [m^2]
};

/// Standard deviation of that distance divided by the distance, including the uncertainty of the
/// clones and cameras. It measures the quality of the first linearisation.
double relative_depth_sigma(const MultiViewStart& start, const Ekf& filter);

/// Workspace of initialise_multi_view.
struct MultiViewScratch {
  std::vector<Camera> cameras;  ///< as estimated; those at the lines of the views follow
  std::vector<View> views;
  std::vector<int> rows;  ///< of the clones and cameras that the views depend on, each once
  Scratch r, H_point, H_others, moved, d_point, workspace, correlation;
};

/// Triangulates the point and linearises all views there. An orthogonal transformation of the rows
/// separates the point from the rest. The noise of the landmark and that of the rest are
/// independent, so that each observation counts once. The landmark is the point as it is observed
/// at the time of the last view, which must be the latest. An anchored landmark is anchored on the
/// last view's clone. None if the views do not meet in a point that all cameras see.
std::optional<MultiViewStart> initialise_multi_view(
    std::span<const Camera> cameras, const TrackNoise& noise, const State& x, LandmarkId id,
    std::span<const ClonedView> views, bool anchored, Linearisation at = Linearisation::kCurrent);
/// The same into an existing result; false for none, and then the result has no meaning.
bool initialise_multi_view(std::span<const Camera> cameras, const TrackNoise& noise, const State& x,
                           LandmarkId id, std::span<const ClonedView> views, bool anchored,
                           Linearisation at, MultiViewScratch& scratch, MultiViewStart& result);

}  // namespace chasles
