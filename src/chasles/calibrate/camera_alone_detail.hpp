#pragma once

#include <string>
#include <vector>

#include <chasles/calibrate/levenberg_marquardt.hpp>
#include <chasles/calibrate/rig_problem_detail.hpp>

/// The calibration of a camera by itself. Private to the calibrate folder.
namespace chasles::calibrate_detail {

constexpr std::size_t kLeastCorners = 4;  ///< of a view
constexpr std::size_t kLeastViews = 3;    ///< of a camera

struct PosedView {
  const TargetView* view;
  SE3 cam_T_target;
};

/// A camera by itself: its lens, and the poses of its views.
struct AloneCamera {
  Camera camera;
  std::vector<PosedView> views;
};

/// For lenses that are compared: the cost to a thousandth of a percent, far below what is alike.
constexpr SearchLimits kRough{.relative_decrease = 1e-5, .decrease = 0.1};
/// For where another search begins. It must know which of two minima is the lower one.
constexpr SearchLimits kFine{.relative_decrease = 1e-9, .decrease = 1e-3};

/// Calibrates a camera by its views, of which each has kLeastCorners. With fx > 0 the search begins
/// at the lens of `first`; without, or where that is far off, at nothing. Throws InputError that
/// begins with `of`.
AloneCamera calibrated_alone(const Camera& first, const LensForm& lens,
                             const std::vector<Eigen::Vector3d>& corners,
                             const std::vector<const TargetView*>& views, const std::string& of,
                             const SearchLimits& limits = kFine);

}  // namespace chasles::calibrate_detail
