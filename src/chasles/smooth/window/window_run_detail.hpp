#pragma once

#include <chasles/smooth/terms/residual_walk.hpp>
#include <chasles/smooth/window/window.hpp>
#include <chasles/smooth/window/window_detail.hpp>

/// The steps of a window after a frame, for all kinds of recordings. Private to this folder.
namespace chasles::smooth_detail {

/// A sliding window with a limited number of keyframes that have a frame, and the map of the
/// landmarks that have left it.
class SlidingWindow {
 public:
  /// Throws UsageError for fewer than two keyframes.
  SlidingWindow(int keyframes, const BatchSettings& settings, const ErrorChart& chart,
                const BlockSizes& sizes);

  Window window;

  /// Adds the newest keyframe with its values; returns its number.
  int push(Time time, const double* motion, const Eigen::VectorXd& additive);
  /// A landmark with its views; returns its number.
  int add(WindowPoint point);
  /// Adds another observation of it.
  void observe(int point, WindowView view);

  /// Marginalises the oldest keyframes to make room for a frame. Returns whether it removed any.
  bool make_room();

  /// Iterates to the minimum and applies the gate; counts into the report.
  struct Optimised {
    Culled culled;
    bool finite = true;
    double squares = 0;  ///< of the residuals of the remaining observations, in sigmas
    int residuals = 0;   ///< their number
  };
  Optimised optimise(WindowReport& report);

  Eigen::MatrixXd newest_covariance(double covariance_factor = 1) const {
    return smooth_detail::newest_covariance(window, factor_, covariance_factor);
  }
  Eigen::MatrixXd calibration_covariance() const {
    return smooth_detail::calibration_covariance(window, factor_);
  }
  /// All landmarks that have left, and those in the window (without a finite minimum: only the
  /// former). The factor multiplies their covariances as that of the newest keyframe.
  std::vector<MapLandmark> map(double covariance_factor = 1);
  int map_size() const { return static_cast<int>(left_.size() + window.points.size()); }

  /// Of the residuals of the keyframes that have left.
  const ResidualWalk& walk() const { return walk_; }

 private:
  void note_walk(int keyframe);
  void refresh();  // makes linear parts and factor current

  int keyframes_;
  BatchSettings settings_;
  WindowFactor factor_;
  ResidualWalk walk_;
  std::vector<WindowLandmark> left_;
  int next_point_ = 0;
};

}  // namespace chasles::smooth_detail
