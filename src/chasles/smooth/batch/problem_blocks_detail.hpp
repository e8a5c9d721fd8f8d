#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <chasles/smooth/batch/batch_settings.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

/// What problems of Ceres have in common here, whatever moves: for this folder's sources alone.
namespace chasles::smooth_detail {

/// How many there are, and how many numbers each has.
struct BlockSizes {
  std::size_t keyframes = 0, points = 0;
  bool velocity = true;  ///< of a keyframe's motion (ChartManifold)
  int additive = 6;      ///< a keyframe's other numbers: biases, a velocity in the body

  int motion() const { return velocity ? kMotionNumbers : kPoseNumbers; }
  int errors() const { return (velocity ? kMotionErrors : kPoseErrors) + additive; }
};

/// The numbers of all blocks in one piece of memory: Ceres orders blocks by their addresses, and
/// the same order gives the same bytes. Keyframe by keyframe motion and additive numbers, then the
/// points.
class ProblemBlocks {
 public:
  // Ceres keeps pointers into the numbers.
  ProblemBlocks(const ProblemBlocks&) = delete;
  ProblemBlocks& operator=(const ProblemBlocks&) = delete;

  ceres::Problem& ceres() { return *problem_; }
  const BlockSizes& sizes() const { return sizes_; }
  const ErrorChart& chart() const { return *chart_; }  ///< of the motions
  double* motion(std::size_t keyframe) { return &numbers_[stride() * keyframe]; }
  double* additive(std::size_t keyframe) {
    return motion(keyframe) + static_cast<std::size_t>(sizes_.motion());
  }
  double* point(std::size_t i) { return &numbers_[stride() * sizes_.keyframes + 3 * i]; }
  /// All blocks in the order of the numbers.
  std::vector<double*> blocks();

  /// Where a block's errors begin in the whole error vector: those of keyframes ([the chart's of
  /// the motion, additive]), behind them all points.
  int keyframe_row(std::size_t k) const { return sizes_.errors() * static_cast<int>(k); }
  int point_row(std::size_t i) const {
    return keyframe_row(sizes_.keyframes) + 3 * static_cast<int>(i);
  }

  /// Of every look at a point at the present numbers, points and their views in order: the length
  /// of the whitened residual.
  std::vector<double> deviations() const;

 protected:
  /// Declares all blocks, poses the identity and all other numbers zero.
  ProblemBlocks(const BlockSizes& sizes, const std::string& chart);
  ~ProblemBlocks() = default;
  /// The blocks of a keyframe: motion and, if there are any, additive numbers.
  std::vector<double*> keyframe(std::size_t k);
  void add_view(ceres::CostFunction* cost, ceres::LossFunction* loss,
                const std::vector<double*>& of);

 private:
  std::size_t stride() const { return static_cast<std::size_t>(sizes_.motion() + sizes_.additive); }

  BlockSizes sizes_;
  const ErrorChart* chart_;
  std::vector<double> numbers_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<ceres::ResidualBlockId> views_;
};

/// So many rows of the error vector.
std::vector<int> range(int first, int count);

constexpr double kLossWidth = 2.5;  ///< where deviations are as stated

/// batch.loss_width; auto: kLossWidth.
double loss_width_of(const BatchSettings& settings);

/// batch.loss, of that width or another; null: none.
ceres::LossFunction* loss_of(const BatchSettings& settings);
ceres::LossFunction* loss_of(const BatchSettings& settings, double width);

/// The problem linearised at the present numbers: residual r and Jacobian J whitened and
/// robustified.
struct NormalEquations {
  Eigen::SparseMatrix<double> lower;  ///< triangle of J^T J
  Eigen::VectorXd gradient;           ///< J^T r
};
NormalEquations normal_equations(ProblemBlocks& problem);

}  // namespace chasles::smooth_detail
