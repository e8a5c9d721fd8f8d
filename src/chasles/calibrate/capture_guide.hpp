#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/base/constants.hpp>
#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/calibrate/view_coverage.hpp>

namespace chasles {

/// How many views of a camera have blurred edges.
class BlurCount {
 public:
  /// Standard deviation of the edges of a view [px]; NaN: unknown, it does not count.
  void add(double blur);
  static bool is_blurred(double blur);  ///< over more than 2 px: fewer corners are found
  /// A sentence with what to do where more than half of the views are; else empty.
  std::string sentence(std::size_t camera) const;

 private:
  std::size_t views_ = 0, blurred_ = 0;
};

/// The lens with which a camera is estimated while its views are recorded: the only candidate,
/// that which the camera states (fx > 0), or equidistant, which bends to most lenses.
LensForm guiding_lens(const Camera& camera, const std::vector<LensForm>& candidates);

/// Says, while views of a target are recorded, what they do not show yet: what calibrate_cameras()
/// would lack at the end. Poses need a lens: each camera is calibrated by itself, by at most 60
/// views, whenever it has half as many more views that differ. The same views in the same order
/// give the same sentences.
class CaptureGuide {
 public:
  /// `input`: as for calibrate_cameras(), without views. Throws UsageError where it has not one
  /// lens for each camera.
  explicit CaptureGuide(CamerasInput input);

  /// A view of a camera. Views may come in any order; those with fewer than four corners show
  /// nothing. `blur`: standard deviation of its edges [px]. Throws as check_view().
  void add(const TargetView& view, double blur = kNaN);

  /// What is missing, one sentence each, the most important first; empty: it is enough.
  std::vector<std::string> missing() const;

  /// Of a camera, as far as its views determine it.
  struct Estimate {
    Camera camera;
    double focal_length = 0, sigma = 0;  ///< fx and its standard deviation [px]
    double rms = 0;                      ///< of the corners' errors [px]
  };
  const std::optional<Estimate>& estimate(std::size_t camera) const;
  std::size_t views(std::size_t camera) const;  ///< with four corners or more
  int pieces() const;                           ///< views that differ, of all cameras
  const CamerasInput& input() const { return input_; }

 private:
  struct OfCamera {
    std::size_t views = 0;
    std::vector<TargetView> different;  ///< each has moved since the one before
    std::size_t next_estimate = 6;      ///< at so many of them
    std::optional<Estimate> estimate = {};
    std::string fault = {};  ///< why the last estimate failed
    BlurCount blur = {};
  };

  void add_pose(const TargetView& view);
  void improve(std::size_t camera);

  CamerasInput input_;  ///< its views: all
  ViewCoverage coverage_;
  std::vector<OfCamera> cameras_;
};

}  // namespace chasles
