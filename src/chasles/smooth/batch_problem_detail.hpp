#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <chasles/smooth/batch_graph_detail.hpp>

/// The graph as a problem of Ceres: for this folder's sources alone.
namespace chasles::smooth_detail {

/// The numbers of all blocks in one piece of memory: Ceres orders blocks by their addresses, and
/// the same order gives the same bytes. Keyframe by keyframe motion and biases, then the points.
class BatchProblem {
 public:
  BatchProblem(const BatchInput& input, const std::string& chart, const BatchSettings& settings,
               const BatchGraph& graph);
  // Ceres keeps pointers into the numbers.
  BatchProblem(const BatchProblem&) = delete;
  BatchProblem& operator=(const BatchProblem&) = delete;
  ~BatchProblem();

  ceres::Problem& ceres() { return *problem_; }
  double* motion(std::size_t keyframe) { return &numbers_[21 * keyframe]; }
  double* biases(std::size_t keyframe) { return &numbers_[21 * keyframe + 15]; }
  double* point(std::size_t i) { return &numbers_[21 * keyframes_ + 3 * i]; }
  /// All blocks in the order of the numbers.
  std::vector<double*> blocks();
  /// The numbers as states and parameters.
  void write_to(BatchGraph& graph);

  /// Of every pixel at the present numbers, points and their views in order: deviations.
  std::vector<double> deviations() const;

 private:
  std::size_t keyframes_, points_;
  std::vector<double> numbers_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<ceres::ResidualBlockId> pixels_;
};

/// Where a block's errors begin in the whole error vector: keyframe k at 15 k ([rotation, position,
/// velocity, biases], the chart's), point i behind all keyframes.
inline int keyframe_row(std::size_t k) { return 15 * static_cast<int>(k); }
inline int point_row(const BatchGraph& graph, std::size_t i) {
  return 15 * static_cast<int>(graph.keyframes.size()) + 3 * static_cast<int>(i);
}

/// Searches the minimum from the present numbers, in at most so many steps. Adds its steps to the
/// report; throws Error(kDiverged).
struct Search {
  int steps = 50;
  double tolerance = 1e-8;
};
void solve(BatchProblem& problem, const BatchGraph& graph, const BatchSettings& settings,
           const Search& search, BatchReport& report);

/// Takes those views out of the graph whose deviations are more than `gate`; an anchored landmark
/// that loses its first view hangs on its next one, and one that is left with a single view goes.
/// Counts into the report; returns how many views went.
int cull(const BatchInput& input, const std::vector<double>& deviations, double gate,
         BatchGraph& graph, BatchReport& report);

/// What the report says of the fit, at the minimum.
void judge(const BatchProblem& problem, const BatchGraph& graph, const BatchSettings& settings,
           BatchReport& report);

/// The lower triangle of J^T J at the present numbers, J the whitened and robustified Jacobian.
Eigen::SparseMatrix<double> normal_matrix(BatchProblem& problem);

}  // namespace chasles::smooth_detail
