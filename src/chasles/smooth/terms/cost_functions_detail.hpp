#pragma once

#include <optional>

#include <ceres/sized_cost_function.h>

#include <chasles/camera/stereo.hpp>
#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

/// The terms of the sum, over blocks motion (15 numbers: chart_manifold_detail.hpp), biases (6) and
/// point (3). Jacobians of a motion have the reference chart's derivatives in their first nine
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

/// A landmark as a term sees it: predicted less measured, and derivatives of that by the point, all
/// over sigma.
template <int Rows>
struct Sight {
  Eigen::Matrix<double, Rows, 1> residual, d_w;
  Eigen::Matrix<double, Rows, 3> d_point;  ///< by p_world of a HomogeneousPoint
  Eigen::Matrix<double, Rows, 6> d_pose;   ///< by [rotation; position], reference chart
};

/// A point that a camera cannot see (behind it, beyond the lens model) counts as so many deviations
/// in every row, and tells no way out: the other views do.
inline constexpr double kNotSeen = 30;

/// Nearer points are not seen [m]. At the filter's kMinDepth a cost would jump by kNotSeen: a point
/// that wrong pixels draw nearer would stay there, and none of the steps that take all else on
/// would be accepted. So near the camera's plane the cost has risen by far more.
inline constexpr double kLeastDepth = 1e-4;

/// The same while a search is on its way from a bad beginning: there true points pass close before
/// cameras, where no step would be worth the residuals that grow beyond all bounds.
inline constexpr double kLeastDepthOnTheWay = kMinDepth;

/// What a camera sees of a landmark.
struct PixelTerm {
  static constexpr int kRows = 2, kNumbers = kMotionNumbers;  // of the residual; of a motion
  const Camera* camera = nullptr;
  const Camera* anchor_camera = nullptr;  ///< of an anchored landmark
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1;
  double least_depth = kLeastDepth;

  std::optional<Sight<2>> see(const SE3& world_T_imu, const HomogeneousPoint& point) const;
  const SE3& anchor_cam_T_imu() const { return anchor_camera->cam_T_imu; }
};

/// A Cartesian landmark. Blocks: motion, point.
template <typename Term>
class PointCost final : public ceres::SizedCostFunction<Term::kRows, Term::kNumbers, 3> {
 public:
  explicit PointCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// An anchored landmark from another keyframe than its anchor. Blocks: motion of the view, of the
/// anchor, point.
template <typename Term>
class AnchoredCost final
    : public ceres::SizedCostFunction<Term::kRows, Term::kNumbers, Term::kNumbers, 3> {
 public:
  explicit AnchoredCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// An anchored landmark from its anchor: where that is does not matter. Block: point.
template <typename Term>
class AnchorCost final : public ceres::SizedCostFunction<Term::kRows, 3> {
 public:
  explicit AnchorCost(const Term& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  Term term_;
};

/// What is known of an inverse depth beforehand. Block: point.
class InverseDepthCost final : public ceres::SizedCostFunction<1, 3> {
 public:
  explicit InverseDepthCost(double sigma) : sigma_(sigma) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  double sigma_;
};

}  // namespace chasles::smooth_detail
