#pragma once

#include <string>
#include <vector>

#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>

/// The graph as a problem of Ceres: for this folder's sources alone.
namespace chasles::smooth_detail {

class BatchProblem final : public ProblemBlocks {
 public:
  BatchProblem(const InertialBatchInput& input, const std::string& chart,
               const BatchSettings& settings, const BatchGraph& graph, double least_depth);
  /// The numbers as states and parameters.
  void write_to(BatchGraph& graph);
};

/// Takes those views out of the graph whose deviations are more than batch.gate, and parts
/// landmarks as parts_that_agree(); an anchored landmark that loses its first view hangs on its
/// next one. One that is left with a single view goes, and of a parted one what has no parallax.
/// Counts into the report; returns how many views went.
int cull(const InertialBatchInput& input, const std::vector<double>& deviations,
         const BatchSettings& settings, BatchGraph& graph, BatchReport& report);

}  // namespace chasles::smooth_detail
