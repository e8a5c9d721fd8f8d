#pragma once

#include <string>

#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>

/// The graph of a recording with body velocities as a problem of Ceres: for this folder's sources
/// alone.
namespace chasles::smooth_detail {

class VelocityProblem final : public ProblemBlocks {
 public:
  /// Keeps references into the graph.
  VelocityProblem(const VelocityBatchInput& input, const BatchSettings& settings,
                  const VelocityGraph& graph, double least_depth);
  /// The numbers as states and parameters.
  void write_to(VelocityGraph& graph);
  int rows() const { return rows_; }  ///< of all views

 private:
  void add_views(const VelocityBatchInput& input, const BatchSettings& settings,
                 const VelocityGraph& graph);
  template <int Rows>
  void add_view_of(StereoTerm<Rows> term, ceres::LossFunction* loss, const VelocityGraph& graph,
                   std::size_t i, const StereoView& view);

  double least_depth_;
  int rows_ = 0;
};

/// Estimates of all framed keyframes and landmarks with their covariances, reference chart, from
/// the problem linearised at the graph's states, which are the problem's numbers in that chart.
void add_estimates(VelocityProblem& problem, const VelocityBatchInput& input,
                   const VelocityGraph& graph, VelocityBatchResult& result);

}  // namespace chasles::smooth_detail
