#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <chasles/smooth/batch/batch_settings.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>
#include <chasles/smooth/terms/chart_manifold_detail.hpp>

/// Common parts of the Ceres problems of this folder. Private to this folder.
namespace chasles::smooth_detail {

/// Numbers of blocks, and their sizes.
struct BlockSizes {
  std::size_t keyframes = 0, points = 0;
  bool velocity = true;  ///< whether a keyframe's motion has a velocity (ChartManifold)
  int additive = 6;      ///< other states of a keyframe: biases, a body velocity
  CalibrationBlocks calibration = {};

  int motion() const { return velocity ? kMotionNumbers : kPoseNumbers; }
  int errors() const { return (velocity ? kMotionErrors : kPoseErrors) + additive; }
};

/// The values of all blocks in one piece of memory. Ceres orders blocks by their addresses, so the
/// same order gives the same bytes. Per keyframe motion and additive states, then the calibration,
/// then the points.
class ProblemBlocks {
 public:
  // Ceres keeps pointers to the values.
  ProblemBlocks(const ProblemBlocks&) = delete;
  ProblemBlocks& operator=(const ProblemBlocks&) = delete;

  ceres::Problem& ceres() { return *problem_; }
  const BlockSizes& sizes() const { return sizes_; }
  const ErrorChart& chart() const { return *chart_; }  ///< of the motions
  double* motion(std::size_t keyframe) { return &numbers_[stride() * keyframe]; }
  double* additive(std::size_t keyframe) {
    return motion(keyframe) + static_cast<std::size_t>(sizes_.motion());
  }
  double* calibration() { return &numbers_[stride() * sizes_.keyframes]; }
  double* calibration(std::size_t block) {
    return calibration() + sizes_.calibration.all()[block].number;
  }
  double* point(std::size_t i) {
    return calibration() + static_cast<std::size_t>(sizes_.calibration.numbers()) + 3 * i;
  }
  /// All blocks in the order of the values.
  std::vector<double*> blocks();

  /// First row of a block in the error vector: per keyframe [the chart's errors of the motion,
  /// additive], then the calibration, then all points.
  int keyframe_row(std::size_t k) const { return sizes_.errors() * static_cast<int>(k); }
  int calibration_row() const { return keyframe_row(sizes_.keyframes); }
  int point_row(std::size_t i) const {
    return calibration_row() + sizes_.calibration.errors() + 3 * static_cast<int>(i);
  }

  /// For every view, in the order of points and their views: its whitened residual at the present
  /// values, and the length of it.
  std::vector<Eigen::VectorXd> whitened_residuals() const;
  std::vector<double> whitened_norms() const;

 protected:
  /// Declares all blocks, with poses the identity and all other values zero.
  ProblemBlocks(const BlockSizes& sizes, const std::string& chart);
  ~ProblemBlocks() = default;
  /// The blocks of a keyframe: motion and, if any, additive states.
  std::vector<double*> keyframe(std::size_t k);
  void add_view(ceres::CostFunction* cost, ceres::LossFunction* loss,
                const std::vector<double*>& of);

 private:
  Eigen::VectorXd whitened_residual(std::size_t view) const;
  std::size_t stride() const { return static_cast<std::size_t>(sizes_.motion() + sizes_.additive); }

  BlockSizes sizes_;
  const ErrorChart* chart_;
  std::vector<double> numbers_;
  std::unique_ptr<ceres::Problem> problem_;
  struct View {
    const ceres::CostFunction* cost;  // of the problem
    std::vector<const double*> blocks;
  };
  std::vector<View> views_;
};

/// The indices first, first + 1, ..., `count` of them.
std::vector<int> range(int first, int count);

constexpr double kLossWidth = 2.5;  ///< where the stated noise is right

/// batch.loss_width; auto: kLossWidth.
double loss_width_of(const BatchSettings& settings);

/// The loss of batch.loss, with that width or another; null: none.
ceres::LossFunction* loss_of(const BatchSettings& settings);
ceres::LossFunction* loss_of(const BatchSettings& settings, double width);

/// The problem linearised at the present values: residual r and Jacobian J, whitened and with the
/// loss applied.
struct NormalEquations {
  Eigen::SparseMatrix<double> lower;  ///< triangle of J^T J
  Eigen::VectorXd gradient;           ///< J^T r
};
NormalEquations normal_equations(ProblemBlocks& problem);

}  // namespace chasles::smooth_detail
