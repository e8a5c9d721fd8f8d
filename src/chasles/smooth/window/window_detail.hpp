#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <chasles/filter/past/history.hpp>
#include <chasles/filter/pixel_projection.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/terms/calibrated_costs_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>
#include <chasles/smooth/window/by_number_detail.hpp>

/// A window that slides over a recording of any kind. Private to this folder. Its terms are those
/// of the batch problems. The linear algebra uses the reference chart's errors. The error chart
/// determines how a step moves a state, and in which coordinates the prior is Gaussian
/// (docs/window.md).
namespace chasles::smooth_detail {

using Matrix63d = Eigen::Matrix<double, 6, 3>;

struct WindowKeyframe {
  Time time{};
  bool framed = false;
  std::array<double, kMotionNumbers> motion{};  ///< kMotionNumbers, or only kPoseNumbers of them
  Eigen::VectorXd additive;
};

/// A term of one keyframe, or of one and the next; and, as its last block, of a block of the
/// calibration.
struct ChainTerm {
  int first = 0, keyframes = 1;
  bool additive_only = false;  ///< its only block is `additive`
  std::unique_ptr<ceres::CostFunction> cost = nullptr;
  Eigen::VectorXd residual = {};  ///< at the present values, unless stale
  Eigen::MatrixXd jacobian =
      {};  ///< by the reference chart's errors of its keyframes, and of its `calibration`
  std::optional<CalibrationBlocks::Block> calibration = {};
};

/// One observation of a landmark.
struct WindowView {
  int keyframe = 0, camera = 0;
  bool match = false;   ///< PixelObservation::is_match()
  bool begins = false;  ///< whether it can initialise a landmark; one that is not in the prior
                        ///< needs such a view
  std::optional<PixelTerm> pixel = {};  ///< by a known camera; then it has no other cost
  std::unique_ptr<ceres::CostFunction> cost = nullptr;       ///< blocks: motion(, anchor's), point
  std::unique_ptr<ceres::CostFunction> at_anchor = nullptr;  ///< block: point
  double whitened_norm = 0;                                  ///< length of the whitened residual

  int rows() const { return pixel ? PixelTerm::kRows : cost->num_residuals(); }
};

/// The linearised views of a landmark at the present values: second derivatives and gradients of
/// half the squares, by the poses of the keyframes that they depend on, by the calibration and by
/// the landmark.
struct PointLinear {
  struct PoseBlock {
    int keyframe = 0;
    Matrix6d H = Matrix6d::Zero(),
             by_anchor = Matrix6d::Zero();  ///< with the first pose block
    Matrix63d W = Matrix63d::Zero();
    Vector6d g = Vector6d::Zero();
  };
  /// By the errors of the calibration, if it is estimated.
  struct CalibrationBlock {
    Eigen::MatrixXd H = {};
    Eigen::Matrix<double, Eigen::Dynamic, 3> W = {};
    Eigen::VectorXd g = {};
    /// By the poses, too, in the order of their blocks; the last ones may be missing: zero.
    std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> by_pose = {};
  };
  std::vector<PoseBlock> pose_blocks = {};  ///< that of the anchor first, if any
  CalibrationBlock calibration = {};
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d V_inverse = Eigen::Matrix3d::Zero();  ///< inverse_on_range, set by evaluate()
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double cost = 0;

  /// inverse_on_range() of V with a diagonal that is enlarged by this fraction.
  Eigen::Matrix3d damped_inverse(double damping) const;
  /// Of a keyframe that is not the anchor's. Views are added in the order of their keyframes.
  PoseBlock& pose_block_of(int keyframe, bool anchored) {
    const std::size_t others = anchored ? 1 : 0;
    if (pose_blocks.size() > others && pose_blocks.back().keyframe == keyframe) {
      return pose_blocks.back();
    }
    return pose_blocks.emplace_back(PoseBlock{.keyframe = keyframe});
  }
};

struct WindowPoint {
  LandmarkId id = 0;
  int anchor = 0;      ///< keyframe in the window, of an anchored landmark
  SE3 cam_T_imu = {};  ///< of the anchor's camera, at the line of its pixel, in a face's axes
  /// If these axes move with estimated extrinsics: how, and the block of these.
  std::optional<AnchorCamera> camera = {};
  std::size_t extrinsics = 0;
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
  std::vector<WindowView> views = {};                    ///< sorted by keyframe
  std::unique_ptr<ceres::CostFunction> alone = nullptr;  ///< a prior of the landmark alone
  int observations = 0;  ///< all views, including those of removed keyframes
  bool in_prior = false;
  bool stale =
      true;  ///< `linear` is not at the present values, or includes views that were removed
  std::size_t linearised = 0;  ///< number of views in `linear`
  PointLinear linear = {};
};

/// The prior at other values than its own (window_prior.cpp).
struct PresentPrior;

/// The information of the marginalised states about the window: 1/2 y^T information y + gradient^T
/// y. y is T^-1 times the chart's errors of the state against `at`, with T the chart's block there.
/// To first order about `at`, y equals the reference chart's errors, but it is linear in the
/// chart's. With scale weights, the scale is among its components (window_scale.cpp). For all
/// keyframes but the oldest, the prior has rows for the pose only.
struct WindowPrior {
  Eigen::MatrixXd information;  ///< lower triangle
  Eigen::VectorXd gradient;
  std::vector<WindowKeyframe> keyframes;             ///< `at`, of the keyframes of the prior
  std::vector<Eigen::MatrixXd> inverse_blocks = {};  ///< T^-1, of these keyframes
  std::vector<double> calibration = {};              ///< `at`, of Window::calibration
  ByNumber<Eigen::Vector3d> points;
  ByNumber<double> scale_weights =
      {};  ///< weights of the points in the scale; empty: the scale is 1
  Eigen::VectorXd scale_direction = {};              ///< derivative of y if all lengths grow
  std::shared_ptr<const PresentPrior> present = {};  ///< at the values of the last evaluate()
};

/// Errors of the calibration that no step moves, and their covariance.
struct WindowConsidered {
  std::vector<int> rows = {};  ///< of the calibration's errors
  Eigen::MatrixXd covariance = {};
};

struct Window {
  BlockSizes sizes;  ///< of a keyframe; the counts are not used
  const ErrorChart* chart = nullptr;
  std::unique_ptr<ceres::LossFunction> loss = nullptr;  ///< of views; null: none
  bool anchored = true;                                 ///< the form of its landmarks

  int first = 0;  ///< the number of the oldest keyframe
  std::deque<WindowKeyframe> keyframes = {};
  std::vector<double> calibration = {};  ///< the numbers of sizes.calibration; always in the prior
  std::vector<std::vector<std::size_t>> camera_blocks = {};  ///< of them, those of each camera
  WindowConsidered considered = {};
  std::vector<ChainTerm> terms = {};
  ByNumber<WindowPoint> points = {};
  WindowPrior prior = {};
  bool stale = true;  ///< the terms' linear parts are not at the present values

  int count() const { return static_cast<int>(keyframes.size()); }
  int last() const { return first + count() - 1; }
  WindowKeyframe& keyframe(int number) {
    return keyframes[static_cast<std::size_t>(number - first)];
  }
  const WindowKeyframe& keyframe(int number) const {
    return keyframes[static_cast<std::size_t>(number - first)];
  }
};

/// The rows of an error vector of the window: the landmarks of the prior, the calibration, then the
/// keyframes, the oldest first. The first `whole` keyframes have all errors, the others those of
/// the pose.
struct WindowRows {
  explicit WindowRows(const Window& window) : WindowRows(window, window.count(), window.count()) {}
  WindowRows(const Window& window, int keyframes, int whole);
  /// Those of the factor: the newest keyframe has all errors, the others those of the pose.
  static WindowRows outer(const Window& window);
  int keyframe(int number) const {
    const int k = number - first, cut = std::max(k - whole, 0);
    return begin + errors * (k - cut) + kPoseErrors * cut;
  }
  int errors_of(int number) const {
    const bool all = number - first < whole || (newest_whole && number - first == keyframes - 1);
    return all ? errors : kPoseErrors;
  }

  ByNumber<int> points;
  int calibration = 0, calibration_errors = 0;
  int begin = 0, errors = 0, first = 0, keyframes = 0, whole = 0, size = 0;
  bool newest_whole = false;
};

/// Half of the weighted squares at the present values; makes all linear parts current.
double evaluate(Window& window);

/// The linear part of a point's views of `keyframe`; none: of all views, and of `alone`.
/// Sets the norms of those views.
PointLinear linearise(const Window& window, WindowPoint& point,
                      std::optional<int> keyframe = std::nullopt);

/// The quadratic form of a window's terms in its errors, with landmarks that are not in the prior
/// eliminated: lower triangle of S, and gradient.
struct WindowSystem {
  Eigen::MatrixXd S;
  Eigen::VectorXd g;
};
/// The lower triangle in other rows: removed rows are dropped, new ones are zero.
WindowSystem in_rows(const WindowSystem& system, const WindowRows& from, const WindowRows& to);
Eigen::VectorXd in_rows(const Eigen::VectorXd& g, const WindowRows& from, const WindowRows& to);
/// The gradient in the rows of all errors; needs current linear parts.
Eigen::VectorXd gradient(const Window& window, const WindowRows& rows);

/// The quadratic form of a window in WindowRows::outer, with the inner errors (InnerStates) apart.
/// Needs current linear parts. Diagonals are enlarged by the fraction `damping`.
class InnerStates;
WindowSystem normal_equations(const Window& window, const WindowRows& rows, double damping,
                              InnerStates& inner);

/// The inverse of a landmark's V on its range; zero on its null space.
Eigen::Matrix3d inverse_on_range(const Eigen::Matrix3d& V);

/// The uncertainty of the window after the last step.
struct WindowFactor {
  /// Lower triangle: S = L L^T, where rows and columns of considered errors are the identity's.
  Eigen::MatrixXd L;
  /// L^-1 S_c, of the columns S_c of S by the considered errors, without their own rows. Minus
  /// L^-T times this is the derivative of the window's errors at the minimum by them.
  Eigen::MatrixXd by_considered = {};
  std::optional<WindowRows> rows = {};  ///< of L; none: the window was not fully observable

  /// Whether it still has the same keyframes.
  bool fits(const Window& window) const {
    return rows && rows->first == window.first && rows->keyframes == window.count();
  }
};
/// The factor at the present values, without damping; needs current linear parts.
WindowFactor factor_of(const Window& window);

struct WindowSteps {
  int steps = 3;            ///< at most
  double tolerance = 1e-8;  ///< relative decrease of the cost at which it ends
  /// Predicted decrease of the cost by another step below which there is none.
  double least_decrease = 0;
};
struct WindowProgress {
  int tried = 0, successful = 0;
  bool converged = false, finite = true;
  double cost = 0;
};
/// Gauss-Newton steps, damped where one does not lower the cost.
WindowProgress improve(Window& window, const WindowSteps& steps, WindowFactor& factor);

/// Removes views that are farther than `gate` standard deviations from their prediction. Removes
/// landmarks that are not in the prior and have only one view left, or no view that can initialise
/// them.
struct CulledView {
  int point = 0, keyframe = 0, camera = 0;
};
struct Culled {
  std::vector<CulledView> views;
  std::vector<int> points;
};
Culled cull(Window& window, double gate);

/// The whitened residual of a view at the present values.
Eigen::VectorXd residual(const Window& window, const WindowPoint& point, const WindowView& view);

/// The covariance of the newest keyframe's errors, reference chart; NaN without a factor.
/// `covariance_factor` multiplies it, but for what considered errors add.
Eigen::MatrixXd newest_covariance(const Window& window, const WindowFactor& factor,
                                  double covariance_factor = 1);

/// The covariance of the calibration's errors; the factor must have rows.
Eigen::MatrixXd calibration_covariance(const Window& window, const WindowFactor& factor);

/// Adds the calibration, at these values, with a prior of that mean and whitening (W^T W =
/// covariance^-1), before there is any keyframe. `cameras`: their number.
void add_calibration(Window& window, const Calibration& at, const Calibration& mean,
                     const Eigen::MatrixXd& whitening, std::size_t cameras);

/// A landmark as an entry of the map, and what considered errors add to its covariance.
struct WindowLandmark {
  MapLandmark landmark;
  Eigen::Matrix3d added = Eigen::Matrix3d::Zero();
};

/// None where its inverse depth is not positive, and without a factor. The factor must fit the
/// window.
std::optional<WindowLandmark> map_landmark(const Window& window, const WindowFactor& factor,
                                           int point);

/// Marginalises the oldest keyframe and its observations into the prior. Landmarks that it observed
/// and the newest keyframe does not are marginalised with all their views. Those that are still
/// observed stay and become part of the prior. Landmarks without a keyframe in the window are
/// removed from `points`. Needs current linear parts.
void marginalise_oldest(Window& window);

/// The numbers of the landmarks that would be marginalised with all keyframes up to `keyframe`;
/// sorted.
std::vector<int> ending_points(const Window& window, int keyframe);

// Shared by the sources of the window.

/// The row of those extrinsics among the calibration's errors.
inline int extrinsics_row(const Window& window, const WindowPoint& point) {
  return window.sizes.calibration.all()[point.extrinsics].row;
}
/// Sets the axes of landmarks by the present extrinsics.
void update_axes(const Window& window, WindowPoint& point);
void update_axes(Window& window);

/// The landmark and its anchor in the form of the filter's charts.
Landmark landmark_of(const WindowPoint& point);
Clone clone_of(const Window& window, int keyframe);

/// T(x) of a keyframe's motion: the chart's errors by the reference chart's.
Eigen::MatrixXd chart_block(const Window& window, const WindowKeyframe& keyframe);

/// The rows of the prior.
WindowRows prior_rows(const Window& window);
/// The prior at the present values, reference chart: lower triangle, its rows.
WindowSystem prior_system(const Window& window);
Eigen::VectorXd prior_gradient(const Window& window);
double prior_cost(const Window& window);
/// Keeps what the three above share for the present values.
void evaluate_prior(Window& window);

/// Sets the prior to that system at the present values; rows: (window, all keyframes, 1). Only the
/// lower triangle is read.
void set_prior(Window& window, WindowSystem system);

/// The logarithm of the ratio of the present scale to that of the prior, from the depths of its
/// landmarks; and its derivative by the prior's rows, reference chart.
struct WindowScale {
  double log = 0;
  Eigen::VectorXd by_errors;
};
WindowScale scale_of(const Window& window, const WindowRows& rows);

/// The present values of the prior's states, scaled about the position of its oldest keyframe.
struct ScaledNumbers {
  std::vector<WindowKeyframe> keyframes;
  ByNumber<Eigen::Vector3d> points;
};
ScaledNumbers scaled(const Window& window, double log);
/// The diagonal derivative of these values by the present ones; reference chart.
Eigen::VectorXd scaling(const Window& window, const WindowRows& rows, double log);
/// The derivative of the reference chart's errors by the logarithm of the scale at those values.
Eigen::VectorXd scale_direction(const Window& window, const WindowRows& rows,
                                const ScaledNumbers& numbers);
/// Chooses the landmarks that define the scale: those whose depths the prior determines.
void weigh_scale(const Window& window, WindowPrior& prior);

/// Adds a landmark's linear part to a system; with its own rows if `row` is given.
void add_point(const WindowRows& rows, const PointLinear& linear, std::optional<int> row,
               const Eigen::Matrix3d& V_inverse, WindowSystem& system);
void add_term(const WindowRows& rows, const ChainTerm& term, WindowSystem& system);

}  // namespace chasles::smooth_detail
