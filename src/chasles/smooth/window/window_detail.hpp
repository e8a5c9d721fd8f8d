#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <chasles/filter/history.hpp>
#include <chasles/filter/pixel_sight.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>

/// A window that slides over a recording, whatever moves in it: for this folder's sources alone.
/// Its terms are those of the batch's problems. The linear algebra is done in the reference chart's
/// errors; the error chart says how a step moves a state and in which coordinates the prior is
/// Gaussian (docs/window.md).
namespace chasles::smooth_detail {

using Matrix63d = Eigen::Matrix<double, 6, 3>;

struct WindowKeyframe {
  Time time{};
  bool framed = false;
  std::array<double, kMotionNumbers> motion{};  ///< or kPoseNumbers of them
  Eigen::VectorXd additive;
};

/// A term of one keyframe, or of one and the next.
struct ChainTerm {
  int first = 0, keyframes = 1;
  bool additive_only = false;  ///< its one block is `additive`
  std::unique_ptr<ceres::CostFunction> cost = nullptr;
  Eigen::VectorXd residual = {};  ///< at the present numbers, unless stale
  Eigen::MatrixXd jacobian = {};  ///< by the reference chart's errors of its keyframes
};

/// A look at a landmark.
struct WindowView {
  int keyframe = 0, camera = 0;
  bool begins = false;  ///< a landmark that is not in the prior needs such a view, if it ever had
  std::unique_ptr<ceres::CostFunction> cost = nullptr;       ///< blocks: motion(, anchor's), point
  std::unique_ptr<ceres::CostFunction> at_anchor = nullptr;  ///< block: point
  double deviation = 0;                                      ///< length of the whitened residual
};

/// What a landmark's views say, at the present numbers: half the squares' second derivatives and
/// gradients by the poses of the keyframes that they hang on and by the landmark.
struct PointLinear {
  struct Seat {
    int keyframe = 0;
    Matrix6d H = Matrix6d::Zero(), by_anchor = Matrix6d::Zero();  ///< with the first seat's pose
    Matrix63d W = Matrix63d::Zero();
    Vector6d g = Vector6d::Zero();
  };
  std::vector<Seat> seats = {};  ///< that of the anchor first, where there is one
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double cost = 0;
};

struct WindowPoint {
  LandmarkId id = 0;
  int anchor = 0;      ///< keyframe, of an anchored one; one of the window
  int camera = 0;      ///< of the anchor
  SE3 cam_T_imu = {};  ///< its
  Eigen::Vector3d parameters = Eigen::Vector3d::Zero();
  std::vector<WindowView> views = {};                    ///< keyframes rise
  std::unique_ptr<ceres::CostFunction> alone = nullptr;  ///< a term of the landmark by itself
  int looks = 0;                                         ///< views, those that have left included
  bool in_prior = false;
  bool stale = true;  ///< `linear` is not of the present numbers, or of views that have gone
  std::size_t linearised = 0;  ///< so many of the views are in `linear`
  PointLinear linear = {};
};

/// What has left the window says of what is in it: 1/2 y^T information y + gradient^T y. y is T^-1
/// times the chart's errors of the state against `at`, T being the chart's block there: to first
/// order about `at` the reference chart's errors, but linear in the chart's; and where there are
/// scale weights, with the scale among them (window_scale.cpp). Of all keyframes but the oldest,
/// what has left saw the poses alone: the others of their errors have no rows.
struct WindowPrior {
  Eigen::MatrixXd information;  ///< lower triangle
  Eigen::VectorXd gradient;
  std::vector<WindowKeyframe> keyframes;             ///< `at`, of those that were there
  std::vector<Eigen::MatrixXd> inverse_blocks = {};  ///< T^-1, of those
  std::map<int, Eigen::Vector3d> points;
  std::map<int, double> scale_weights = {};  ///< of points in what the scale is; empty: it is 1
  Eigen::VectorXd scale_direction = {};      ///< of y, if all lengths grow
};

struct Window {
  BlockSizes sizes;  ///< of a keyframe; the counts are not used
  const ErrorChart* chart = nullptr;
  std::unique_ptr<ceres::LossFunction> loss = nullptr;  ///< of views; null: none
  bool anchored = true;                                 ///< the form of its landmarks

  int first = 0;  ///< the number of the oldest keyframe
  std::deque<WindowKeyframe> keyframes = {};
  std::vector<ChainTerm> terms = {};
  std::map<int, WindowPoint> points = {};
  WindowPrior prior = {};
  bool stale = true;  ///< the terms' linear parts are not those of the present numbers

  int count() const { return static_cast<int>(keyframes.size()); }
  int last() const { return first + count() - 1; }
  WindowKeyframe& keyframe(int number) {
    return keyframes[static_cast<std::size_t>(number - first)];
  }
  const WindowKeyframe& keyframe(int number) const {
    return keyframes[static_cast<std::size_t>(number - first)];
  }
};

/// Where everything stands in an error vector of the window: the landmarks of the prior, then the
/// oldest keyframes. Of the first `whole` of them all errors are there, of the others the pose's.
struct WindowRows {
  explicit WindowRows(const Window& window) : WindowRows(window, window.count(), window.count()) {}
  WindowRows(const Window& window, int keyframes, int whole);
  int keyframe(int number) const {
    const int k = number - first, cut = std::max(k - whole, 0);
    return begin + errors * (k - cut) + kPoseErrors * cut;
  }
  int errors_of(int number) const { return number - first < whole ? errors : kPoseErrors; }

  std::map<int, int> points;  ///< by number
  int begin = 0, errors = 0, first = 0, keyframes = 0, whole = 0, size = 0;
};

/// Half of the weighted squares at the present numbers; makes all linear parts current.
double evaluate(Window& window);

/// The linear part of those of a point's views that are of `keyframe`; none: all, and `alone`.
PointLinear linearise(const Window& window, const WindowPoint& point,
                      std::optional<int> keyframe = std::nullopt);

/// The quadratic form that a window's terms make of its errors, landmarks that are not in the prior
/// eliminated: lower triangle of S, and gradient.
struct WindowSystem {
  Eigen::MatrixXd S;
  Eigen::VectorXd g;
};
/// The lower triangle in other rows: without those that are not there any more, zeros where there
/// were none.
WindowSystem in_rows(const WindowSystem& system, const WindowRows& from, const WindowRows& to);
/// Needs current linear parts. Diagonals are enlarged by that part of themselves.
WindowSystem normal_equations(const Window& window, const WindowRows& rows, double damping);

/// The inverse of a landmark's V on what it tells; what it does not tell stays as it is.
Eigen::Matrix3d inverse_on_range(const Eigen::Matrix3d& V);

/// What the last step found of the window's uncertainty.
struct WindowFactor {
  Eigen::MatrixXd L;                    ///< lower triangle: S = L L^T
  std::optional<WindowRows> rows = {};  ///< of L; none: the window was not determined

  /// Whether no keyframe has come or gone since.
  bool fits(const Window& window) const {
    return rows && rows->first == window.first && rows->keyframes == window.count();
  }
};
/// That of the present numbers, without damping; needs current linear parts.
WindowFactor factor_of(const Window& window);

struct WindowSteps {
  int steps = 3;            ///< at most
  double tolerance = 1e-8;  ///< it ends where the cost falls by less than this part
};
struct WindowProgress {
  int tried = 0, successful = 0;
  bool converged = false, finite = true;
  double cost = 0;
};
/// Gauss's and Newton's steps, damped where one does not lower the cost.
WindowProgress improve(Window& window, const WindowSteps& steps, WindowFactor& factor);

/// Views that are farther than `gate` deviations from their prediction go. Landmarks that are not
/// in the prior and are left with one view, or without the view that begins them, go as well.
struct CulledView {
  int point = 0, keyframe = 0, camera = 0;
};
struct Culled {
  std::vector<CulledView> views;
  std::vector<int> points;
};
Culled cull(Window& window, double gate);

/// The covariance of the newest keyframe's errors, reference chart; NaN without a factor.
Eigen::MatrixXd newest_covariance(const Window& window, const WindowFactor& factor);

/// A landmark as the map has it; none where it is beyond infinity, and without a factor. The factor
/// fits the window.
std::optional<MapLandmark> map_landmark(const Window& window, const WindowFactor& factor,
                                        int point);

/// The oldest keyframe leaves, and with it what was observed from it: into the prior. Landmarks
/// that it saw and that the newest keyframe does not see go with all their views; those that are
/// still seen stay, and are of the prior from now on. What is of no keyframe of the window any more
/// has left `points`. Current linear parts are needed.
void marginalise_oldest(Window& window);

/// The numbers of those that would go with all keyframes up to that one, which rise.
std::vector<int> ending_points(const Window& window, int keyframe);

// Between the window's sources.

/// The landmark and its anchor as the filter's charts take them.
Landmark landmark_of(const WindowPoint& point);
Clone clone_of(const Window& window, int keyframe);

/// T(x) of a keyframe's motion: the chart's errors by the reference chart's.
Eigen::MatrixXd chart_block(const Window& window, const WindowKeyframe& keyframe);

/// Where everything stands in the prior.
WindowRows prior_rows(const Window& window);
/// What the prior says at the present numbers, reference chart: lower triangle, its rows.
WindowSystem prior_system(const Window& window);
double prior_cost(const Window& window);

/// The prior of that system at the present numbers; rows: (window, all keyframes, 1). Its lower
/// triangle is read.
void set_prior(Window& window, WindowSystem system);

/// The logarithm of what the present numbers are larger by than those of the prior, by the depths
/// of its landmarks; and its derivative by the prior's rows, reference chart.
struct WindowScale {
  double log = 0;
  Eigen::VectorXd by_errors;
};
WindowScale scale_of(const Window& window, const WindowRows& rows);

/// The present numbers of what the prior has, larger by a factor about where its oldest keyframe
/// was.
struct ScaledNumbers {
  std::vector<WindowKeyframe> keyframes;
  std::map<int, Eigen::Vector3d> points;
};
ScaledNumbers scaled(const Window& window, double log);
/// The derivative of that by the present numbers, which is diagonal; reference chart.
Eigen::VectorXd scaling(const Window& window, const WindowRows& rows, double log);
/// The reference chart's errors by the logarithm, if those numbers grow.
Eigen::VectorXd scale_direction(const Window& window, const WindowRows& rows,
                                const ScaledNumbers& numbers);
/// Says which landmarks tell the scale: those whose depths the prior knows.
void weigh_scale(const Window& window, WindowPrior& prior);

/// Adds a landmark's linear part to a system; by its own rows where `row` says where they are.
void add_point(const WindowRows& rows, const PointLinear& linear, std::optional<int> row,
               const Eigen::Matrix3d& V_inverse, WindowSystem& system);
void add_term(const WindowRows& rows, const ChainTerm& term, WindowSystem& system);

}  // namespace chasles::smooth_detail
