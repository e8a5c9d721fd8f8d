#pragma once

#include <optional>

#include <ceres/sized_cost_function.h>

#include <chasles/camera/stereo.hpp>
#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

/// The terms of the cost, over blocks motion (15 numbers: chart_manifold_detail.hpp), biases (6)
/// and point (3). Jacobians of a motion have the reference chart's derivatives in their first nine
/// columns.
namespace chasles::smooth_detail {

/// Blocks: motion, biases of the first keyframe.
class StartCost final : public ceres::SizedCostFunction<15, kMotionNumbers, 6> {
 public:
  explicit StartCost(const BatchGraph& graph) : graph_(&graph) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const BatchGraph* graph_;
};

/// Blocks: motion, biases of a keyframe; of the next.
class LinkCost final : public ceres::SizedCostFunction<15, kMotionNumbers, 6, kMotionNumbers, 6> {
 public:
  LinkCost(const ImuLink& link, const Eigen::Vector3d& gravity) : link_(&link), gravity_(gravity) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  const ImuLink* link_;
  Eigen::Vector3d gravity_;
};

/// The residual of a landmark in one term: prediction minus measurement, and its derivatives by the
/// point and the pose, all over sigma.
template <int Rows>
struct PredictedView {
  Eigen::Matrix<double, Rows, 1> residual, d_w;
  Eigen::Matrix<double, Rows, 3> d_point;  ///< by p_world of a HomogeneousPoint
  Eigen::Matrix<double, Rows, 6> d_pose;   ///< by [rotation; position], reference chart
};

/// Residual in standard deviations, in every row, of a point that a camera cannot see (behind it,
/// beyond the lens model). Its derivative is zero; only the other views move the point.
inline constexpr double kNotSeen = 30;

/// Nearer points are not visible [m]. At the filter's kMinDepth the cost would jump by kNotSeen. A
/// point that wrong pixels draw nearer would stay there, and no further step would be accepted. So
/// near the camera's plane the cost has risen by far more.
inline constexpr double kLeastDepth = 1e-4;

/// The same while the search leaves a bad initial guess. Then correct points pass close to cameras,
/// where unbounded residuals would prevent every step.
inline constexpr double kLeastDepthOnTheWay = kMinDepth;

/// A pixel observation of a landmark.
struct PixelTerm {
  static constexpr int kRows = 2, kNumbers = kMotionNumbers;  // of the residual; of a motion
  const Camera* camera = nullptr;
  SE3 cam_T_imu = {};  ///< at the line of the pixel (camera/rolling_shutter.hpp)
  SE3 of_anchor = {};  ///< the same of the anchor of an anchored landmark
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1;
  double least_depth = kLeastDepth;

  std::optional<PredictedView<2>> see(const SE3& world_T_imu, const HomogeneousPoint& point) const;
  const SE3& anchor_cam_T_imu() const { return of_anchor; }
};

/// How a view depends on its landmark: as PointCost, AnchoredCost or AnchorCost.
enum class ViewForm { kPoint, kAnchored, kAnchor };

/// A Cartesian landmark. Blocks: motion, point.
template <typename Term>
class PointCost final : public ceres::SizedCostFunction<Term::kRows, Term::kNumbers, 3> {
 public:
  explicit PointCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// An anchored landmark observed from another keyframe than its anchor. Blocks: motion of the view,
/// of the anchor, point.
template <typename Term>
class AnchoredCost final
    : public ceres::SizedCostFunction<Term::kRows, Term::kNumbers, Term::kNumbers, 3> {
 public:
  explicit AnchoredCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// An anchored landmark observed from its anchor, whose pose has no effect. Block: point.
template <typename Term>
class AnchorCost final : public ceres::SizedCostFunction<Term::kRows, 3> {
 public:
  explicit AnchorCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// The prior of an inverse depth. Block: point.
class InverseDepthCost final : public ceres::SizedCostFunction<1, 3> {
 public:
  explicit InverseDepthCost(double sigma) : sigma_(sigma) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  double sigma_;
};

}  // namespace chasles::smooth_detail
