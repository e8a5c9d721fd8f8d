#pragma once

#include <algorithm>
#include <utility>

#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>

/// The search for the minimum, for any kind of batch. Private to this folder.
namespace chasles::smooth_detail {

/// Relative decrease of the cost in a step: below kArrived the search has left a bad initial guess;
/// below kRough it has roughly converged, and outliers can be detected.
inline constexpr double kArrived = 1e-2, kRough = 1e-3;
/// The search is at its minimum where a full step should lower the cost by less than this fraction.
inline constexpr double kAtMinimum = 1e-7;

/// A search for the minimum over several problems in turn, with at most batch.max_iterations steps
/// in all, which the report counts.
class Search {
 public:
  /// Keeps the references.
  Search(const BatchSettings& settings, BatchReport& report, StopRequest stop = {})
      : settings_(&settings), report_(&report), stop_(std::move(stop)) {}
  /// Continues from the present values until a step lowers the cost by less than the fraction
  /// `tolerance`. Throws Error(kDiverged) and BatchStopped.
  void run(ProblemBlocks& problem, double tolerance);

 private:
  const BatchSettings* settings_;
  BatchReport* report_;
  StopRequest stop_;
  double trust_radius_ = 0;  ///< radius of the trust region after the last step
};

/// The error chart of the steps: batch.chart, or that of the filter.
const std::string& chart_of(const BatchSettings& settings, const std::string& of_filter);

/// Throws Error(kDiverged) where the gate left no landmark.
void check_left(std::size_t points, const BatchReport& report);

/// The ids of a graph's landmarks.
template <typename Point>
std::vector<LandmarkId> ids_of(const std::vector<Point>& points) {
  std::vector<LandmarkId> ids;
  for (const Point& point : points) ids.push_back(point.id);
  return ids;
}

/// Throws Error(kDiverged) where a landmark ended at a position that none of its pixels constrains,
/// because no camera sees it there (kNotSeen). `equations`: the problem's normal_equations; `ids`:
/// of all landmarks in the problem's order.
void check_determined(const NormalEquations& equations, const ProblemBlocks& problem,
                      const std::vector<LandmarkId>& ids);

/// Minimises the problem that `make` builds from the graph and a least depth, and writes the
/// minimum into the graph. The search first uses kLeastDepthOnTheWay and, after it has left a bad
/// initial guess, the final least depth. With a gate, `cull` removes outliers from the graph when
/// the search has roughly converged, and returns their number.
template <typename Graph, typename Make, typename Cull>
auto at_minimum(Graph& graph, const BatchSettings& settings, BatchReport& report, const Make& make,
                const Cull& cull, const StopRequest& stop) {
  auto problem = make(kLeastDepthOnTheWay);
  Search search(settings, report, stop);
  const auto run = [&](double tolerance) {
    search.run(*problem, tolerance);
    problem->write_to(graph);
  };
  run(std::max(kArrived, settings.tolerance));
  problem = make(kLeastDepth);
  if (settings.gate_sigmas() > 0) {
    run(std::max(kRough, settings.tolerance));
    if (report.converged && cull(problem->whitened_norms()) > 0) {
      check_left(graph.points.size(), report);
      problem = make(kLeastDepth);
    }
  }
  run(settings.tolerance);
  return problem;
}

/// Reports the fit at the minimum. `dof`: rows of the observations minus parameters of the
/// landmarks. Links have as many rows as a keyframe has components; so has the start.
void assess(const ProblemBlocks& problem, int dof, const BatchSettings& settings,
            BatchReport& report);

/// Reports the end of the search: its distance from a minimum, g^T H^-1 g of gradient and normal
/// matrix, and whether it stalled.
void assess_end(double squared_distance, BatchReport& report);

}  // namespace chasles::smooth_detail
