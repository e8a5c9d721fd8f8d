#pragma once

#include <ceres/sized_cost_function.h>

#include <chasles/smooth/batch_graph_detail.hpp>
#include <chasles/smooth/chart_manifold_detail.hpp>

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

/// What a camera sees of a landmark: the residual, predicted less measured, over sigma. A point
/// that it cannot see (behind it, beyond the lens model) counts as kNotSeen deviations in both
/// directions, and tells no way out: the other views do.
struct PixelTerm {
  const Camera* camera = nullptr;
  const Camera* anchor_camera = nullptr;  ///< of an anchored landmark
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1;
};
inline constexpr double kNotSeen = 30;

/// A Cartesian landmark. Blocks: motion, point.
class PointCost final : public ceres::SizedCostFunction<2, kMotionNumbers, 3> {
 public:
  explicit PointCost(const PixelTerm& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  PixelTerm term_;
};

/// An anchored landmark from another keyframe than its anchor. Blocks: motion of the view, of the
/// anchor, point.
class AnchoredCost final : public ceres::SizedCostFunction<2, kMotionNumbers, kMotionNumbers, 3> {
 public:
  explicit AnchoredCost(const PixelTerm& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  PixelTerm term_;
};

/// An anchored landmark from its anchor: where that is does not matter. Block: point.
class AnchorCost final : public ceres::SizedCostFunction<2, 3> {
 public:
  explicit AnchorCost(const PixelTerm& term) : term_(term) {}
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override;

 private:
  PixelTerm term_;
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
