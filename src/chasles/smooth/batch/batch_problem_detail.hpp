#pragma once

#include <string>
#include <vector>

#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

/// The graph as a Ceres problem. Private to this folder.
namespace chasles::smooth_detail {

class BatchProblem final : public ProblemBlocks {
 public:
  /// Whether considered rows of the calibration keep their values, or move as the others do: for
  /// the derivatives by them.
  enum class Considered { kHeld, kFree };

  BatchProblem(const InertialBatchInput& input, const std::string& chart,
               const BatchSettings& settings, const BatchGraph& graph, double least_depth,
               Considered considered = Considered::kHeld);
  /// Writes the problem's values into the graph's states and parameters.
  void write_to(BatchGraph& graph);

 private:
  void add_motion(const BatchGraph& graph);
  void add_calibration(const InertialBatchInput& input, const BatchGraph& graph);
  void hold(const std::vector<int>& considered);
  void add_views(const InertialBatchInput& input, const BatchSettings& settings,
                 const BatchGraph& graph, double least_depth);
  std::vector<double*> blocks_of(const PointView& view, ViewForm form, int anchor, std::size_t i);

  const InertialBatchInput* input_;
};

/// Removes the views with residuals above batch.gate standard deviations, and splits landmarks as
/// parts_that_agree(). An anchored landmark that loses its first view moves its anchor to the next
/// one. Landmarks with a single view are removed, and parts of a split landmark without parallax.
/// Counts into the report; returns the number of removed views.
int cull(const InertialBatchInput& input, const std::vector<double>& whitened_norms,
         const BatchSettings& settings, BatchGraph& graph, BatchReport& report);

}  // namespace chasles::smooth_detail
