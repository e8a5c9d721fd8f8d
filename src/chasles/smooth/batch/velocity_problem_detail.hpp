#pragma once

#include <string>

#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/batch/velocity_graph_detail.hpp>

/// The graph of a recording with body velocities as a Ceres problem. Private to this folder.
namespace chasles::smooth_detail {

class VelocityProblem final : public ProblemBlocks {
 public:
  /// Keeps references to the graph.
  VelocityProblem(const VelocityBatchInput& input, const BatchSettings& settings,
                  const VelocityGraph& graph, double least_depth);
  /// Writes the problem's values into the graph's states and parameters.
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

/// Adds estimates of all keyframes with a frame, and of the landmarks, with their covariances,
/// reference chart, from the problem linearised at the graph's states. The problem's blocks must
/// hold these states.
void add_estimates(VelocityProblem& problem, const VelocityBatchInput& input,
                   const VelocityGraph& graph, VelocityBatchResult& result,
                   const StopRequest& stop = {});

}  // namespace chasles::smooth_detail
