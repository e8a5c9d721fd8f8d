#pragma once

#include <chasles/smooth/window/window.hpp>
#include <chasles/smooth/window/window_detail.hpp>

/// What windows over all kinds of recordings do after a frame: for this folder's sources alone.
namespace chasles::smooth_detail {

/// A window that slides: of its keyframes so many are of frames, and the map of what has left it.
class SlidingWindow {
 public:
  /// Throws UsageError for fewer than two keyframes.
  SlidingWindow(int keyframes, const BatchSettings& settings, const ErrorChart& chart,
                const BlockSizes& sizes);

  Window window;

  /// The numbers of a keyframe that is newer than all others; returns its own.
  int push(Time time, const double* motion, const Eigen::VectorXd& additive);
  /// A landmark with its views; returns its number.
  int add(WindowPoint point);
  /// Another view of it.
  void look(int point, WindowView view);

  /// Room for a frame: what is too old leaves. Returns whether something did.
  bool make_room();

  /// Steps to the minimum, and the gate; counts into the report.
  struct Settled {
    Culled culled;
    bool finite = true;
  };
  Settled settle(WindowReport& report);

  Eigen::MatrixXd newest_covariance() const {
    return smooth_detail::newest_covariance(window, factor_);
  }
  /// All that have left, and those that are there (without a finite minimum: the former alone).
  std::vector<MapLandmark> map();
  int map_size() const { return static_cast<int>(left_.size() + window.points.size()); }

 private:
  void refresh();  // linear parts and factor are those of the window

  int keyframes_;
  BatchSettings settings_;
  WindowFactor factor_;
  std::vector<MapLandmark> left_;
  int next_point_ = 0;
};

}  // namespace chasles::smooth_detail
