#pragma once

#include <string>

#include <chasles/smooth/drive_graph_detail.hpp>
#include <chasles/smooth/problem_blocks_detail.hpp>

/// The graph of a recording with body velocities as a problem of Ceres: for this folder's sources
/// alone.
namespace chasles::smooth_detail {

class DriveProblem final : public ProblemBlocks {
 public:
  /// Keeps references into the graph.
  DriveProblem(const DriveInput& input, const BatchSettings& settings, const DriveGraph& graph,
               double least_depth);
  /// The numbers as states and parameters.
  void write_to(DriveGraph& graph);
  int rows() const { return rows_; }  ///< of all views

 private:
  void add_views(const DriveInput& input, const BatchSettings& settings, const DriveGraph& graph);
  template <int Rows>
  void add_view_of(StereoTerm<Rows> term, ceres::LossFunction* loss, const DriveGraph& graph,
                   std::size_t i, const StereoView& view);

  double least_depth_;
  int rows_ = 0;
};

/// Estimates of all framed keyframes and landmarks with their covariances, reference chart, from
/// the problem linearised at the graph's states, which are the problem's numbers in that chart.
void add_estimates(DriveProblem& problem, const DriveInput& input, const DriveGraph& graph,
                   DriveResult& result);

}  // namespace chasles::smooth_detail
